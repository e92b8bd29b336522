// One vertical line through all plots at the time under the pointer, with the values there.
const LEFT=54,RIGHT=6,BOTTOM=18,TOP=16,plots=[...document.querySelectorAll("svg.plot")];
const at=(svg,x)=>{const v=[];for(const l of svg.querySelectorAll("polyline")){const p=l.points;let a=0,b=p.numberOfItems-1;
 if(b<0||x<p.getItem(0).x||x>p.getItem(b).x)continue;
 while(b-a>1){const m=(a+b)>>1;p.getItem(m).x<=x?a=m:b=m}
 const s=p.getItem(a),e=p.getItem(b),k=e.x>s.x?(x-s.x)/(e.x-s.x):0,y=s.y+k*(e.y-s.y),h=svg.viewBox.baseVal.height,
 low=+svg.dataset.low,high=+svg.dataset.high;v.push(+(low+(h-BOTTOM-y)/(h-TOP-BOTTOM)*(high-low)).toPrecision(4))}return v};
const show=t=>{for(const svg of plots){const from=+svg.dataset.from,to=+svg.dataset.to,c=svg.querySelector(".cursor"),r=svg.querySelector(".read");
 if(!(t>=from&&t<=to)){c.style.visibility=r.style.visibility="hidden";continue}
 const w=svg.viewBox.baseVal.width,x=LEFT+(t-from)/(to-from)*(w-LEFT-RIGHT);c.setAttribute("x1",x);c.setAttribute("x2",x);
 r.textContent=t.toFixed(3)+" s: "+at(svg,x).join(", ");r.setAttribute("x",x>w/2?x-4:x+4);r.style.textAnchor=x>w/2?"end":"start";
 c.style.visibility=r.style.visibility="visible"}};
for(const svg of plots)svg.addEventListener("pointermove",e=>{const b=svg.getBoundingClientRect(),w=svg.viewBox.baseVal.width,
 x=(e.clientX-b.left)/b.width*w;show(+svg.dataset.from+(x-LEFT)/(w-LEFT-RIGHT)*(svg.dataset.to-svg.dataset.from))});
for(const a of document.querySelectorAll("[data-t]"))a.addEventListener("click",()=>show(+a.dataset.t));
addEventListener("beforeprint",()=>document.querySelectorAll("details").forEach(d=>d.open=true));
