//! Common data representation: the bytes of a ROS 2 message.
//!
//! Four bytes say "plain CDR, little endian"; then come the fields in order, each primitive aligned to its
//! own size counted from after these four bytes.

use byteorder::LittleEndian;
use serde::{Serialize, de::DeserializeOwned};

const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Replaces what is in `bytes` by the encoded message.
pub(super) fn encode(message: &impl Serialize, bytes: &mut Vec<u8>) {
    bytes.clear();
    bytes.extend_from_slice(&ENCAPSULATION);
    // Writing to memory does not fail, and every sequence of ours knows its length.
    cdr_encoding::to_writer::<_, LittleEndian, _>(bytes, message).expect("messages are plain structs");
}

/// The message in these bytes.
///
/// # Errors
/// A sentence: another encapsulation, a length that lies, text that is not UTF-8, bytes left over.
pub(super) fn decode<M: DeserializeOwned>(bytes: &[u8]) -> Result<M, String> {
    let Some((&ENCAPSULATION, fields)) = bytes.split_first_chunk() else {
        return Err("does not start as plain little-endian CDR".to_owned());
    };
    let (message, used) =
        cdr_encoding::from_bytes::<M, LittleEndian>(fields).map_err(|error| error.to_string())?;
    if used != fields.len() {
        return Err(format!("{} bytes are left over after the last field", fields.len() - used));
    }
    Ok(message)
}
