// The page: controls made of the case's parameters, runs on the server, and what is stored of them.

import {chart} from "./curves.js";
import {FIELDS, box, draw, limits, outlined, places, unpacked} from "./picture.js";

const $ = id => document.getElementById(id);
const SHOWN = {m: ["mm", 1e-3], Pa: ["kPa", 1e3]};
const MAIN = ["radius", "thickness", "young_gray", "young_white", "poisson"];
const LAST = ["elements", "halved", "dynamics", "duration", "seed", "steps", "until"];
const UNDER_WAY = ["starting", "running"];
const POLL = 250, LIST = 2500; // ms
const page = {cases: new Map(), case: null, scene: "", values: {}, a: null, b: null, live: true, playing: null, failed: false};

async function ask(path, body) {
  const reply = await fetch(`api/${path}`, body && {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(body)});
  if (reply.ok) return reply;
  const words = await reply.text();
  let told;
  try { told = JSON.parse(words).error; } catch { told = words; }
  throw new Error(told || `The server answers ${reply.status}.`);
}
const table = async (path, body) => (await ask(path, body)).json();
const arrays = async path => unpacked(await (await ask(path)).arrayBuffer());

function tell(words) { $("notice").hidden = !words; $("notice").textContent = words || ""; }
/** Return what does something, and says why it did not succeed. */
const trying = action => async (...given) => { try { tell(""); return await action(...given); } catch (error) { tell(error.message); } };

function make(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}
const round = (value, digits = 4) => Number(value.toPrecision(digits)).toString();
const unitOf = one => SHOWN[one.unit] || [one.unit, 1];
// a preview has the coarse mesh of the quick version, but goes on to the end
const usual = one => $("quick").checked && !one.name.startsWith("until") ? one.quick : one.usual;
const valueOf = one => one.name in page.values ? page.values[one.name] : usual(one);

// controls

function reach(one, value) {
  const [low, high] = [one.low ?? -Infinity, one.high ?? Infinity];
  if (value === null) return [low, Math.min(high, low + 59)]; // the case chooses it
  if (!value) return [Math.max(low, -1), Math.min(high, one.kind === "int" ? 20 : 1)];
  const [near, far] = value > 0 ? [value / 3, 3 * value] : [3 * value, value / 3];
  return [Math.max(low, near), Math.min(high, far)];
}

function change(one, value) {
  if (value === usual(one)) delete page.values[one.name]; else page.values[one.name] = value;
  keepLink();
}

function knob(one) {
  const [unit, factor] = unitOf(one), shown = value => value === null ? "" : Number((value / factor).toPrecision(10));
  const bounds = one.low === null && one.high === null ? "" : `, ${one.low === null ? "" : `from ${shown(one.low)} `}${one.high === null ? "" : `to ${shown(one.high)} `}${unit}`;
  const row = make("div", {className: "knob", title: `${one.label || one.name}${bounds.trimEnd()}\nusually ${one.kind === "bool" ? (usual(one) ? "on" : "off") : typeof usual(one) === "number" ? shown(usual(one)) : usual(one) ?? "chosen by the case"} ${unit}\non the command line: --set ${one.name}=`});
  const label = make("span", {textContent: one.label || one.name}), mark = () => row.classList.toggle("changed", one.name in page.values);
  const id = `knob-${one.name}`;
  if (one.kind === "bool") {
    const box = make("input", {type: "checkbox", id, checked: valueOf(one), onchange: () => { change(one, box.checked); mark(); }});
    row.append(make("label", {className: "switch"}, box, label));
  } else if (one.kind === "str") {
    const menu = make(one.choices.length ? "select" : "input", {id, onchange: () => { change(one, menu.value); mark(); }}, ...one.choices.map(word => make("option", {value: word, textContent: word})));
    menu.value = valueOf(one);
    row.classList.add("word");
    row.append(label, menu);
  } else {
    const whole = one.kind === "int", [low, high] = reach(one, usual(one)), digits = Math.floor(Math.log10((high - low) / factor / 100));
    const set = (text, from) => {
      const given = Number(text), empty = text.trim() === "";
      if (empty ? usual(one) !== null : !Number.isFinite(given)) return;
      change(one, empty ? null : whole ? Math.round(given) : Number((given * factor).toPrecision(10)));
      mark();
      if (from === slider) number.value = shown(valueOf(one)); else slider.value = given;
    };
    const step = whole ? 1 : 10 ** digits;
    const slider = make("input", {type: "range", min: whole ? Math.ceil(low) : Math.ceil(low / factor / step) * step, max: whole ? Math.floor(high) : high / factor, step, ariaLabel: one.label, oninput: () => set(slider.value, slider)});
    const number = make("input", {type: "number", id, step: "any", placeholder: usual(one) === null ? "auto" : "", oninput: () => set(number.value, number)});
    slider.value = number.value = shown(valueOf(one));
    if (unit) label.append(" ", make("small", {textContent: unit}));
    row.append(label, number, slider);
  }
  mark();
  return row;
}

function layOut() {
  const every = page.case.parameters, main = MAIN.map(name => every.find(one => one.name === name)).filter(Boolean);
  const course = every.filter(one => LAST.includes(one.name)), rest = every.filter(one => ![...main, ...course].includes(one));
  const [switches, words] = ["bool", "str"].map(kind => rest.filter(one => one.kind === kind));
  const physics = rest.filter(one => !["bool", "str"].includes(one.kind));
  const groups = [["Body and tissue", main], ["Hypotheses", switches], ["Choices", words], [main.length ? "Growth, pattern and pull" : "Parameters", physics], ["Mesh and course", course]];
  $("controls").replaceChildren(...groups.filter(group => group[1].length).flatMap(([title, some]) => [make("h2", {textContent: title}), ...some.map(knob)]),
    make("button", {textContent: "Back to the case's values", onclick: () => { page.values = {}; layOut(); keepLink(); }}));
  document.title = `${page.case.name} · turingfold`;
  $("case").title = page.case.title;
  if (!page.a) show();
}

async function choose(name, scene, values = {}) {
  if (!page.cases.has(name)) throw new Error(`There is no case ${name} here; there are: ${[...page.cases.keys()].join(", ")}.`);
  const one = page.case = page.cases.get(name);
  const known = page.case.parameters.map(one => one.name), unknown = Object.keys(values).find(key => !known.includes(key));
  page.values = unknown ? {} : values;
  $("case").value = name;
  layOut();
  $("scene").replaceChildren(); // until they are known: some cases need files
  page.scene = scene ?? ""; // no more that of the case before, in the link and in what is run
  $("run").disabled = true;
  one.scenes = one.scenes ?? await table(`cases/${encodeURIComponent(name)}/scenes`);
  if (page.case !== one) return; // another one was chosen meanwhile
  $("scene").replaceChildren(...one.scenes.map(word => make("option", {value: word, textContent: word})));
  if (scene && page.case.scenes.includes(scene)) $("scene").value = scene;
  page.scene = $("scene").value;
  $("run").disabled = false;
  keepLink();
  if (unknown) throw new Error(`${name} has no parameter ${unknown}; its own values are shown.`);
  if (scene && page.scene !== scene) throw new Error(`${name} has no scene ${scene}; ${page.scene} is shown.`);
}

// the link: everything that a run is made of, behind the # of the address

function keepLink() {
  const parts = new URLSearchParams({case: page.case.name, scene: page.scene, quick: $("quick").checked ? "on" : "off", ...page.values});
  history.replaceState(null, "", `#${parts}`);
}

async function openLink(first) {
  const {case: name = first, scene, quick, ...texts} = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
  $("quick").checked = quick !== "off";
  const own = page.cases.get(name)?.parameters ?? [];
  const read = ([key, text]) => {
    const kind = own.find(one => one.name === key)?.kind;
    return [key, kind === "bool" ? text === "true" : kind === "str" || kind === undefined ? text : Number(text)];
  };
  await choose(name, scene, Object.fromEntries(Object.entries(texts).map(read)));
}

// runs

/** Return a run with what is known of it: info of the server, mesh, frames by step. */
const opened = id => ({id, info: null, mesh: null, frames: new Map(), limits: {}, box: null});

async function refresh(run) {
  run.info = await table(`runs/${run.id}`);
  const frames = run.info.frames ?? [];
  if (!frames.length) return;
  run.mesh ??= outlined(await arrays(`runs/${run.id}/mesh`), run.info.mirror);
  for (const step of run.frames.keys()) if (!frames.some(frame => frame.step === step)) run.frames.delete(step); // taken back
  for (const {step} of [...frames.slice(-1), ...frames].filter(frame => !run.frames.has(frame.step))) {
    if (run.frames.has(step)) continue; // the last, which comes first
    const fields = await arrays(`runs/${run.id}/frames/${step}`);
    run.frames.set(step, fields);
    const [l, b, r, t] = box(places(run.mesh, fields), run.mesh.mirror), old = run.box ?? [l, b, r, t];
    run.box = [Math.min(l, old[0]), Math.min(b, old[1]), Math.max(r, old[2]), Math.max(t, old[3])];
    for (const name of Object.keys(FIELDS)) if (fields[name]) {
      const [low, high] = limits(fields[name], name), own = run.limits[name] ?? [low, high];
      run.limits[name] = [Math.min(low, own[0]), Math.max(high, own[1])];
    }
    if (run === page.a && step === frames.at(-1).step) show();
  }
}

const over = run => run.info && !UNDER_WAY.includes(run.info.status) && run.frames.size === (run.info.frames?.length ?? 0);

async function select(slot, id) {
  page[slot] = id ? opened(id) : null;
  if (slot === "a") { page.live = true; pause(); }
  if (page.a && page.b && page.a.id === page.b.id) page.b = null;
  sessionStorage.setItem("runs", JSON.stringify([page.a?.id, page.b?.id]));
  if (page[slot]) await refresh(page[slot]);
  show();
  await list();
}

/** Show a run of the list, and its values in the controls. */
async function again(one) {
  await select("a", one.id);
  if (!page.cases.has(one.case)) return;
  $("quick").checked = one.quick;
  await choose(one.case, one.scene, {...one.values});
}

async function run() {
  const until = page.case.parameters.filter(one => one.name.startsWith("until")).map(one => [one.name, valueOf(one)]);
  const values = {...Object.fromEntries(until), ...page.values};
  const {id} = await table("runs", {case: page.case.name, scene: page.scene, values, quick: $("quick").checked});
  await select("a", id);
}

/** Return the values of a run that differ from the case's, in words. */
function changes({case: name, values}) {
  const known = page.cases.get(name)?.parameters ?? [];
  return Object.entries(values).map(([key, value]) => {
    const [unit, factor] = unitOf(known.find(one => one.name === key) ?? {unit: ""});
    return `${key.replaceAll("_", " ")} ${typeof value === "number" ? `${round(value / factor, 6)} ${unit}`.trim() : value === true ? "on" : value || "off"}`;
  }).join(", ");
}

async function list() {
  const every = await table("runs");
  $("runs").replaceChildren(...every.map(one => {
    const item = make("li", {className: one.id === page.a?.id ? "shown" : one.id === page.b?.id ? "other" : "", onclick: trying(() => again(one)), title: one.message || one.command});
    item.dataset.run = one.id;
    const compare = one.id === page.a?.id ? "" : make("button", {textContent: one.id === page.b?.id ? "uncompare" : "compare", onclick: trying(event => { event.stopPropagation(); return select("b", one.id === page.b?.id ? null : one.id); })});
    const early = one.status === "converged" || one.time == null ? "" : `at time ${round(one.time, 3)}: `; // numbers of a run that ended early
    const result = one.folds == null ? "" : `${early}${one.folds} sulci, index ${one.gyrification_index.toFixed(2)}`;
    item.append(make("span", {textContent: `${one.case} · ${one.scene}`}), make("span", {className: `status ${one.status}`, textContent: one.status}),
      make("small", {textContent: [one.began.slice(11, 16), changes(one), one.quick ? "preview" : "", result].filter(Boolean).join(" · ")}), compare);
    return item;
  }));
  if (!every.length) $("runs").append(make("li", {className: "empty", textContent: "none yet"}));
}

async function poll() {
  try {
    for (const one of [page.a, page.b]) if (one && !over(one)) {
      const before = one.info?.status;
      await refresh(one);
      if (before !== one.info.status) await list();
      show();
    }
    if (page.failed) { page.failed = false; tell(""); }
  } catch (error) {
    page.failed = true;
    tell(error instanceof TypeError ? "The server does not answer; is turingfold app still running? What is stored stays." : error.message);
  }
  setTimeout(poll, POLL);
}

// what is shown

/** Return the frame that is nearest to a share of a run's time; null until it is loaded. */
function frameAt(run, share) {
  const distance = frame => Math.abs(frame.time / run.info.until - share);
  const best = (run?.info?.frames ?? []).reduce((best, frame) => !best || distance(frame) <= distance(best) ? frame : best, null);
  return best && run.frames.has(best.step) ? best : null;
}

const alike = () => page.a.info.length[1] === page.b.info.length[1]; // lengths in the same unit

/** Return the numbers of a frame by name: [value, digits]. */
function measured(run, frame) {
  const row = frame.step - 1, [length, word] = run.info.length, at = name => row < 0 ? null : run.info.curves[name][row];
  const long = value => value == null ? null : value / length;
  return {
    "growth factor": [frame.step ? at("growth") : 1, 3], "sulci": [frame.folds, 0], [`mean sulcal depth, ${word}`]: [frame.folds ? long(frame.sulcal_depth) : null, 2],
    "gyrification index": [at("gyrification_index"), 3], [word === "T" ? "energy" : "energy, J/m"]: [at("energy"), 4], [`smallest gap, ${word}`]: [long(at("min_gap")), 3],
  };
}

function numbers(frame, other) {
  const ours = measured(page.a, frame), theirs = other && measured(page.b, other), signed = text => text.replace("-", "−");
  const written = (value, digits) => value == null ? "–" : signed(value.toFixed(digits));
  const rows = Object.entries(ours).map(([name, [a, digits]]) => {
    const cells = [make("td", {textContent: name}), make("td", {textContent: written(a, digits), className: theirs ? "" : "big"})];
    if (theirs) {
      const b = theirs[name]?.[0], share = b ? ` ${signed((100 * (a - b) / Math.abs(b)).toFixed(0))} %` : "";
      cells.push(make("td", {textContent: written(b, digits)}), make("td", {textContent: a == null || b == null ? "–" : written(a - b, digits)}, make("small", {textContent: a == null || b == null ? "" : share})));
    }
    return make("tr", {}, ...cells);
  });
  if (theirs) rows.unshift(make("tr", {}, ...[["", ""], ["this", "a"], ["other", "b"], ["difference", ""]].map(([textContent, className]) => make("th", {textContent, className}))));
  $("numbers").replaceChildren(...rows);
  $("numbers").dataset.compared = theirs ? "yes" : "no";
}

function curves(frame, other) {
  const word = page.a.info.length[1], runs = other ? [page.a, page.b] : [page.a], until = page.a.info.until;
  const column = name => run => run.info.curves.time.map((t, k) => [t, run.info.curves[name][k]]);
  const depth = run => run.info.frames.map(one => [one.time, one.folds ? one.sulcal_depth / run.info.length[0] : 0]);
  const charts = [["Gyrification index", column("gyrification_index")], [`Sulcal depth, ${word}`, depth], [word === "T" ? "Energy" : "Energy, J/m", column("energy")]];
  $("curves").replaceChildren(...charts.map(([title, points], which) => {
    const some = which && other && !alike() ? [page.a] : runs;
    const series = some.map((run, k) => ({points: points(run).filter(point => point[1] != null).map(([t, v]) => [t / run.info.until * until, v]), color: k ? "#d55e00" : "#0072b2", dash: k ? "5 3" : ""}));
    return chart(title, "time", series, until, frame.time, [($("curves").clientWidth - 20) / 3, $("curves").clientHeight]);
  }));
}

function progress() {
  const info = page.a?.info, under = info && UNDER_WAY.includes(info.status);
  $("stop").disabled = !under;
  $("resume").hidden = !info || !["interrupted", "stopped"].includes(info.status);
  if (!info) return;
  const {time = [], seconds = []} = info.curves ?? {}, last = time.length - 1, share = last < 0 ? 0 : time[last] / info.until;
  $("bar").value = share;
  const since = Math.max(0, last - 4), gone = last > 0 ? time[last] - (since ? time[since - 1] : 0) : 0, spent = seconds.slice(since).reduce((a, b) => a + b, 0);
  const left = gone > 0 ? `${Math.ceil((info.until - time[last]) / gone * spent)} s left` : "";
  $("left").textContent = under ? (info.status === "starting" ? "starting …" : `${Math.round(100 * share)} %  ${left}`) : info.status === "converged" ? "done" : info.status;
  $("left").title = info.message;
  if (info.message && ["refused", "stopped", "invalid", "damaged"].includes(info.status) && page.told !== info.id + info.status) { page.told = info.id + info.status; tell(info.message); }
}

function show() {
  progress();
  const frames = (page.a?.info?.frames ?? []).filter(frame => page.a.frames.has(frame.step));
  $("hint").hidden = frames.length > 0;
  if (!frames.length) {
    $("hint").textContent = page.a ? { refused: "This run was refused." }[page.a.info?.status] ?? "The run starts: its mesh is made, and its pattern computed …" : "";
    if (!page.a) $("hint").append(make("p", {textContent: page.case?.title ?? ""}), make("p", {}, "Choose a case, change what you like, and press ", make("b", {textContent: "Run"}), "."));
    for (const id of ["numbers", "curves", "keep"]) $(id).replaceChildren();
    $("picture").width = $("picture").width; // empty
    return;
  }
  $("time").max = frames.length - 1;
  if (page.live) $("time").value = frames.length - 1;
  const run = page.a, frame = frames[Math.min(frames.length - 1, $("time").value)], fields = run.frames.get(frame.step);
  const there = Object.keys(FIELDS).filter(name => name === "layer" || fields[name]);
  if ([...$("field").options].map(option => option.value).join() !== there.join()) {
    const before = $("field").value;
    $("field").replaceChildren(...there.map(value => make("option", {value, textContent: FIELDS[value].title})));
    if (there.includes(before)) $("field").value = before;
  }
  const share = frame.time / run.info.until, other = frameAt(page.b, share), field = $("field").value;
  const {status} = run.info, ended = frame === frames.at(-1) && !UNDER_WAY.includes(status) && status !== "converged" ? `, ${status} here` : "";
  const {growth} = run.info.curves, caption = `${run.info.case}, ${run.info.scene}: ${frame.label ? `${frame.label}, ` : ""}growth ${(frame.step ? growth[frame.step - 1] ?? 1 : 1).toFixed(2)}, ${frame.folds} sulci${ended}`;
  const view = {mesh: run.mesh, fields, field, limits: field === "layer" ? [0, 1] : run.limits[field], box: run.box, unit: run.info.length, stress: run.info.stress, before: $("outline").checked, caption};
  if (other) {
    const apart = Math.abs(other.time / page.b.info.until - share) > 0.02 && `at time ${round(other.time, 3)}`;
    view.legend = `other: ${[`${page.b.info.case}, ${page.b.info.scene}`, changes(page.b.info), apart].filter(Boolean).join(", ")}`;
  }
  if (other && alike()) {
    view.other = {mesh: page.b.mesh, fields: page.b.frames.get(other.step)};
    view.box = run.box.map((v, k) => k < 2 ? Math.min(v, page.b.box[k]) : Math.max(v, page.b.box[k]));
  }
  draw($("picture"), view);
  $("picture").dataset.step = frame.step;
  $("when").textContent = `${frame.label || `time ${round(frame.time, 3)} of ${round(run.info.until, 3)}`}`;
  $("about").textContent = run.info.command;
  $("about").title = `${run.info.command}\nrepeats this run`;
  numbers(frame, other);
  curves(frame, other);
  keep(frame);
}

// what can be kept

function save(name, blob) {
  const link = make("a", {href: URL.createObjectURL(blob), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function keep(frame) {
  const {id, info} = page.a, field = ["von_mises", "pressure", "jacobian"].includes($("field").value) ? $("field").value : "von_mises";
  const key = `${id} ${frame.step} ${field} ${info.status}`;
  if ($("keep").dataset.of === key && $("keep").children.length) return;
  $("keep").dataset.of = key;
  const file = (title, name, tip, query = "") => make("button", {textContent: title, title: tip, onclick: trying(async event => {
    const button = event.target;
    [button.disabled, button.textContent] = [true, `${title} …`];
    try { save(`${info.case}-${id}-${name}`, await (await ask(`runs/${id}/files/${name}${query}`)).blob()); } finally { [button.disabled, button.textContent] = [false, title]; }
  })});
  $("keep").replaceChildren(
    make("button", {textContent: "PNG", title: "The picture as it is here", onclick: () => $("picture").toBlob(blob => save(`${info.case}-${id}-${frame.step}.png`, blob))}),
    file("PDF", "section.pdf", "The section as a figure for print", `?step=${frame.step}&field=${field}`), file("Film", "film.gif", "The folding as a film (GIF); takes some seconds"),
    file("CSV", "history.csv", "Numbers of every step"), file("ParaView", "frames.zip", "Fields of the stored states (VTU, PVD)"), file("Case", "case.py", "The file of the case"),
    make("button", {textContent: "Copy command", title: info.command, onclick: trying(event => copy(info.command, event.target))}));
}

async function copy(text, button) {
  try { await navigator.clipboard.writeText(text); } catch { throw new Error(`Copy it by hand: ${text}`); }
  const before = button.textContent;
  button.textContent = "Copied";
  setTimeout(() => { button.textContent = before; }, 1200);
}

// playing

function pause() { clearInterval(page.playing); page.playing = null; $("play").textContent = "▶"; }

function play() {
  if (page.playing) return pause();
  if (Number($("time").value) >= $("time").max) $("time").value = 0;
  page.live = false;
  $("play").textContent = "❚❚";
  page.playing = setInterval(() => { $("time").value = Number($("time").value) + 1; show(); if (Number($("time").value) >= $("time").max) pause(); }, 150);
  return show();
}

async function begin() {
  const {first, cases} = await table("cases");
  cases.forEach(one => page.cases.set(one.name, one));
  $("case").append(...cases.map(one => make("option", {value: one.name, textContent: one.name.replaceAll("_", " "), title: one.title})));
  $("case").onchange = trying(() => choose($("case").value));
  $("scene").onchange = () => { page.scene = $("scene").value; keepLink(); };
  $("quick").onchange = () => { layOut(); keepLink(); };
  $("run").onclick = trying(run);
  $("stop").onclick = trying(() => table(`runs/${page.a.id}/stop`, {}));
  $("resume").onclick = trying(async () => { await table(`runs/${page.a.id}/resume`, {}); await select("a", page.a.id); });
  $("link").onclick = trying(event => copy(location.href, event.target));
  $("field").onchange = $("outline").onchange = show;
  $("time").oninput = () => { page.live = Number($("time").value) >= $("time").max; pause(); show(); };
  $("play").onclick = play;
  window.onhashchange = trying(() => openLink(first));
  new ResizeObserver(show).observe($("stage"));
  const [a, b] = JSON.parse(sessionStorage.getItem("runs") ?? "[]");
  await trying(() => openLink(first))();
  for (const [slot, id] of [["a", a], ["b", b]]) if (id) await trying(() => select(slot, id))();
  await list();
  setInterval(() => document.hidden || list().catch(() => {}), LIST);
  poll();
}

trying(begin)();
