// The section on a canvas: quadratic triangles filled with the colours of a field, drawn from stored numbers.

import {ticks} from "./curves.js";

const VIRIDIS = ["440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"];
const LAYERS = ["efe9dc", "9aa7b4"];
const CORE = "ece9e3", INK = "#2b2f36", RED = "#d55e00";
const CUTS = 4; // of an element's edge
export const FIELDS = {
  von_mises: {title: "von Mises stress", stress: true}, activator: {title: "Activator"}, growth: {title: "Growth along the surface", from: 1},
  layer: {title: "Layers and mesh"}, pressure: {title: "Pressure", stress: true, centred: true}, jacobian: {title: "Elastic volume ratio J*", centred: true},
  contact_pressure: {title: "Contact pressure", stress: true, few: true},
};

/** Return the arrays by name that the server packed. */
export function unpacked(buffer) {
  const length = new DataView(buffer).getUint32(0, true), found = {};
  let offset = 4 + length;
  for (const {name, shape, kind} of JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)))) {
    const count = shape.reduce((a, b) => a * b, 1);
    found[name] = new (kind === "u" ? Uint32Array : Float32Array)(buffer, offset, count);
    offset += 4 * count;
  }
  return found;
}

// The shape functions of a quadratic triangle at the points of a lattice, and the small triangles between these.
const [SHAPES, SMALL] = (() => {
  const shapes = [], small = [], place = (i, j) => i * (CUTS + 1) - i * (i - 1) / 2 + j;
  for (let i = 0; i <= CUTS; i++) for (let j = 0; j <= CUTS - i; j++) {
    const b = i / CUTS, c = j / CUTS, a = 1 - b - c;
    shapes.push([a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a]);
    if (i + j < CUTS) small.push([place(i, j), place(i + 1, j), place(i, j + 1)]);
    if (i + j < CUTS - 1) small.push([place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)]);
  }
  return [shapes, small];
})();

function palette(colors) {
  const rgb = colors.map(c => [0, 2, 4].map(k => parseInt(c.slice(k, k + 2), 16)));
  return Uint32Array.from({length: 256}, (_, k) => {
    const at = k / 255 * (rgb.length - 1), i = Math.min(Math.floor(at), rgb.length - 2);
    const [r, g, b] = rgb[i].map((low, n) => Math.round(low + (at - i) * (rgb[i + 1][n] - low)));
    return 255 << 24 | b << 16 | g << 8 | r;
  });
}
const COLORS = palette(VIRIDIS), TISSUES = palette(LAYERS), BLANK = palette([CORE, CORE])[0];

/** Return the mesh with its outline, the line between its layers, and all edges: each [node, middle, node]. */
export function outlined(mesh, mirror) {
  const edges = new Map(), {points, triangles, layer} = mesh;
  for (let e = 0; e < layer.length; e++) for (let k = 0; k < 3; k++) {
    const a = triangles[6 * e + k], b = triangles[6 * e + (k + 1) % 3], key = a < b ? `${a} ${b}` : `${b} ${a}`;
    const edge = edges.get(key);
    if (edge) edge.layers.push(layer[e]);
    else edges.set(key, {nodes: [a, triangles[6 * e + 3 + k], b], layers: [layer[e]]});
  }
  const all = [...edges.values()], width = points.reduce((a, b) => Math.max(a, Math.abs(b)), 0);
  const inner = edge => mirror && edge.nodes.every(n => Math.abs(points[3 * n]) < 1e-6 * width);
  const nodes = found => found.map(edge => edge.nodes);
  return {...mesh, mirror, edges: nodes(all), outline: nodes(all.filter(edge => edge.layers.length === 1 && !inner(edge))),
    interface: nodes(all.filter(edge => edge.layers.length === 2 && edge.layers[0] !== edge.layers[1]))};
}

/** Return places (x, y by node) of a state; without fields those before growth. */
export function places(mesh, fields) {
  const n = mesh.points.length / 3, found = new Float32Array(2 * n);
  for (let k = 0; k < n; k++) for (let i = 0; i < 2; i++) found[2 * k + i] = mesh.points[3 * k + i] + (fields ? fields.displacement[3 * k + i] : 0);
  return found;
}

/** Return [left, bottom, right, top] of places. */
export function box(places, mirror) {
  let [l, b, r, t] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let k = 0; k < places.length; k += 2) {
    l = Math.min(l, places[k]); r = Math.max(r, places[k]); b = Math.min(b, places[k + 1]); t = Math.max(t, places[k + 1]);
  }
  return mirror ? [Math.min(l, -r), b, Math.max(r, -l), t] : [l, b, r, t];
}

/** Return the limits of a field's colours: what all but 1 % of the elements stay within, or of the few that have any. */
export function limits(values, field) {
  const {from = 0, centred, few} = FIELDS[field];
  const sorted = Float32Array.from(values).filter(value => few ? value > 0 : Number.isFinite(value)).sort(), last = sorted.length - 1;
  if (few) return [0, last < 0 ? 1e-9 : sorted[Math.floor(0.9 * last)]];
  const low = centred ? sorted[Math.floor(0.01 * last)] : Math.min(from, sorted[Math.floor(0.01 * last)]), high = sorted[Math.ceil(0.99 * last)];
  return high > low ? [low, high] : [low, low + Math.max(1e-9, Math.abs(low) * 0.01)];
}

/** Return values at the six nodes of each element: averages within a layer of values in triangles. */
function spread(mesh, values) {
  const {triangles, layer} = mesh, n = mesh.points.length / 3;
  if (values.length === n) return Float32Array.from(triangles, node => values[node]);
  const sums = [new Float32Array(n), new Float32Array(n)], counts = [new Uint16Array(n), new Uint16Array(n)];
  triangles.forEach((node, k) => { const e = Math.floor(k / 6), side = layer[e] ? 1 : 0; sums[side][node] += values[e]; counts[side][node]++; });
  return Float32Array.from(triangles, (node, k) => { const side = layer[Math.floor(k / 6)] ? 1 : 0; return sums[side][node] / counts[side][node]; });
}

/** Fill a triangle of pixels with colours that run evenly between its corners (x, y, colour 0 to 255). */
function fill(pixels, width, height, p, i, j, k, colors) {
  const [x0, y0, v0, x1, y1, v1, x2, y2, v2] = [p[i], p[i + 1], p[i + 2], p[j], p[j + 1], p[j + 2], p[k], p[k + 1], p[k + 2]];
  const area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
  if (!area) return;
  const top = Math.max(0, Math.floor(Math.min(y0, y1, y2))), bottom = Math.min(height - 1, Math.ceil(Math.max(y0, y1, y2)));
  const left = Math.max(0, Math.floor(Math.min(x0, x1, x2))), right = Math.min(width - 1, Math.ceil(Math.max(x0, x1, x2)));
  const db = (y2 - y0) / area, dc = (y0 - y1) / area, slack = -1e-6;
  for (let y = top; y <= bottom; y++) {
    let b = ((left + 0.5 - x0) * (y2 - y0) - (x2 - x0) * (y + 0.5 - y0)) / area;
    let c = ((x1 - x0) * (y + 0.5 - y0) - (left + 0.5 - x0) * (y1 - y0)) / area;
    for (let x = left; x <= right; x++, b += db, c += dc) if (b >= slack && c >= slack && 1 - b - c >= slack) {
      const v = v0 + b * (v1 - v0) + c * (v2 - v0);
      pixels[y * width + x] = colors ? colors[v < 0 ? 0 : v > 255 ? 255 : v | 0] : BLANK;
    }
  }
}

/** Draw a state. view: {mesh, fields, field, limits, box, unit: [m, name], stress: [Pa, name], before, other, caption, legend}. */
export function draw(canvas, view) {
  const scale = window.devicePixelRatio || 1, width = Math.round(canvas.clientWidth * scale), height = Math.round(canvas.clientHeight * scale);
  if (!width || !height) return;
  [canvas.width, canvas.height] = [width, height];
  const g = canvas.getContext("2d"), {mesh, fields, field} = view, place = places(mesh, fields);
  const image = g.createImageData(width, height), pixels = new Uint32Array(image.data.buffer).fill(0xffffffff);
  const [l, b, r, t] = view.box, [room, roof, floor] = [96 * scale, (view.legend ? 60 : 40) * scale, 48 * scale];
  const zoom = Math.min((width - room - 30 * scale) / (r - l), (height - roof - floor) / (t - b));
  const x0 = (width - room) / 2 - zoom * (l + r) / 2, y0 = (height + roof - floor) / 2 + zoom * (b + t) / 2;
  const signs = mesh.mirror ? [1, -1] : [1], [low, high] = view.limits;
  const values = spread(mesh, field === "layer" ? mesh.layer : fields[field]), spots = new Float32Array(3 * SHAPES.length);
  for (const sign of signs) for (let e = 0; e < mesh.layer.length; e++) {
    let blank = false;
    for (let s = 0; s < SHAPES.length; s++) {
      let x = 0, y = 0, v = 0;
      for (let k = 0; k < 6; k++) {
        const node = mesh.triangles[6 * e + k], weight = SHAPES[s][k];
        x += weight * place[2 * node]; y += weight * place[2 * node + 1]; v += weight * values[6 * e + k];
      }
      spots[3 * s] = x0 + zoom * sign * x; spots[3 * s + 1] = y0 - zoom * y; spots[3 * s + 2] = 255 * (v - low) / (high - low);
      blank ||= Number.isNaN(v);
    }
    for (const [i, j, k] of SMALL) fill(pixels, width, height, spots, 3 * i, 3 * j, 3 * k, blank ? null : field === "layer" ? TISSUES : COLORS);
  }
  g.putImageData(image, 0, 0);
  const stroke = (mesh, place, edges, color, thick) => {
    g.beginPath();
    for (const sign of mesh.mirror ? [1, -1] : [1]) for (const [a, m, c] of edges) {
      const at = n => [x0 + zoom * sign * place[2 * n], y0 - zoom * place[2 * n + 1]];
      const [xa, ya] = at(a), [xm, ym] = at(m), [xc, yc] = at(c);
      g.moveTo(xa, ya);
      g.quadraticCurveTo(2 * xm - (xa + xc) / 2, 2 * ym - (ya + yc) / 2, xc, yc);
    }
    g.strokeStyle = color; g.lineWidth = thick * scale; g.lineCap = "round";
    g.stroke();
  };
  if (field === "layer") stroke(mesh, place, mesh.edges, "rgba(43, 47, 54, .28)", 0.6);
  stroke(mesh, place, mesh.interface, "rgba(255, 255, 255, .75)", 0.9);
  if (view.before) for (const [color, thick] of [["rgba(255, 255, 255, .7)", 2.4], ["rgba(90, 98, 108, .9)", 0.8]]) stroke(mesh, places(mesh), mesh.outline, color, thick);
  stroke(mesh, place, mesh.outline, INK, 1.3);
  if (view.other) stroke(view.other.mesh, places(view.other.mesh, view.other.fields), view.other.mesh.outline, RED, 1.8);
  g.font = `${13 * scale}px system-ui, "DejaVu Sans", sans-serif`;
  g.textBaseline = "middle";
  g.fillStyle = INK;
  g.fillText(view.caption, 14 * scale, 20 * scale);
  if (view.legend) { g.fillStyle = RED; g.fillText(view.legend, 14 * scale, 41 * scale); }
  rule(g, view, zoom, scale, height);
  bar(g, view, scale, width, height);
}

function rule(g, view, zoom, scale, height) {
  const [unit, name] = view.unit, length = ticks(0, 150 * scale / zoom / unit, 2).pop() || 1, y = height - 22 * scale, long = length * unit * zoom;
  g.fillStyle = g.strokeStyle = INK;
  g.lineWidth = 2 * scale;
  g.beginPath(); g.moveTo(16 * scale, y); g.lineTo(16 * scale + long, y); g.stroke();
  g.fillText(`${length} ${name}`, 24 * scale + long, y);
}

function bar(g, view, scale, width, height) {
  const tall = Math.min(260 * scale, height - 110 * scale), x = width - 78 * scale, y = (height - tall) / 2 + 6 * scale, wide = 12 * scale;
  const {title, stress} = FIELDS[view.field], factor = stress ? 1 / view.stress[0] : 1;
  const ink = k => "#" + (view.field === "layer" ? LAYERS : VIRIDIS)[k];
  g.textAlign = "right"; g.fillStyle = INK;
  g.fillText(title + (stress && view.stress[1] ? `, ${view.stress[1]}` : ""), width - 14 * scale, y - 18 * scale);
  g.textAlign = "left";
  if (view.field === "layer") {
    ["core", "cortex"].forEach((word, k) => { g.fillStyle = ink(k); g.fillRect(x - 10 * scale, y + 22 * (1 - k) * scale, wide, wide); g.fillStyle = INK; g.fillText(word, x + 8 * scale, y + (22 * (1 - k) + 6) * scale); });
    return;
  }
  const shade = g.createLinearGradient(0, y + tall, 0, y);
  VIRIDIS.forEach((_, k) => shade.addColorStop(k / (VIRIDIS.length - 1), ink(k)));
  g.fillStyle = shade;
  g.fillRect(x, y, wide, tall);
  g.fillStyle = INK;
  const [low, high] = view.limits.map(v => v * factor);
  for (const v of ticks(low, high, 5)) {
    const at = y + tall * (1 - (v - low) / (high - low));
    g.fillRect(x + wide, at - scale / 2, 4 * scale, scale);
    g.fillText(v, x + wide + 8 * scale, at);
  }
}
