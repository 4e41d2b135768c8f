// Small charts of numbers over time, as SVG.

const LEFT = 52, RIGHT = 14, TOP = 34, BOTTOM = 36; // pixels
const LEAST = 1e-3; // a range, as a share of the numbers in it: of less, their ticks would look alike

/** Return about `count` round numbers between two. */
export function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find(k => k * power >= rough * 0.999) * power;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}

function element(name, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** Return a chart of so many pixels; series: [{points: [[x, y], ...], color, dash}], now: an x that is marked. */
export function chart(title, label, series, until, now, [WIDTH, HEIGHT]) {
  const svg = element("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": title});
  svg.append(element("text", {x: 12, y: 20, class: "title"}, title));
  const values = series.flatMap(one => one.points.map(point => point[1]));
  let low = Math.min(...values), high = Math.max(...values);
  if (!values.length) [low, high] = [0, 1];
  const least = LEAST * Math.max(Math.abs(low), Math.abs(high)) || 1;
  if (high - low < least) high = low + least;
  const x = t => LEFT + (WIDTH - LEFT - RIGHT) * t / until;
  const y = v => HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (v - low) / (high - low);
  for (const v of ticks(low, high, 4)) {
    svg.append(element("line", {x1: LEFT, x2: WIDTH - RIGHT, y1: y(v), y2: y(v), class: "grid"}));
    svg.append(element("text", {x: LEFT - 6, y: y(v) + 4, "text-anchor": "end"}, v.toString().length > 7 ? v.toExponential(1) : v));
  }
  for (const t of ticks(0, until, Math.min(5, WIDTH / 60))) svg.append(element("text", {x: x(t), y: HEIGHT - 21, "text-anchor": "middle"}, t));
  svg.append(element("text", {x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 7, "text-anchor": "middle"}, label));
  svg.append(element("line", {x1: x(now), x2: x(now), y1: TOP - 4, y2: HEIGHT - BOTTOM, stroke: "#b9c1ca"}));
  for (const one of series) {
    const points = one.points.map(([t, v]) => `${x(t).toFixed(1)},${y(v).toFixed(1)}`).join(" ");
    svg.append(element("polyline", {points, fill: "none", stroke: one.color, "stroke-width": 1.8, "stroke-linejoin": "round", "stroke-dasharray": one.dash || ""}));
  }
  return svg;
}
