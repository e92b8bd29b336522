//! The word that was probably meant.

/// The candidate nearest to `word`, if one is near enough to be meant: at most a third of its letters
/// differ, or one of the two begins with the other. The first of equals.
pub(crate) fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut best: Option<(usize, &str)> = None;
    for candidate in candidates {
        let mut distance = strsim::damerau_levenshtein(word, candidate);
        let shorter = word.len().min(candidate.len());
        if shorter >= 4 && (candidate.starts_with(word) || word.starts_with(candidate)) {
            distance = distance.min(1);
        }
        let near = distance <= word.chars().count().max(candidate.chars().count()) / 3;
        if near && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_was_meant() {
        let checks = ["clearance", "tracking", "slip", "place"];
        assert_eq!(nearest("clearence", checks.into_iter()), Some("clearance"));
        assert_eq!(nearest("trakcing", checks.into_iter()), Some("tracking"));
        assert_eq!(nearest("sleep", checks.into_iter()), None);
        assert_eq!(nearest("", checks.into_iter()), None);
    }
}
