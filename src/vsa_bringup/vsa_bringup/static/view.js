// Keeps the connection, the last half minute of bins, and everything on the page up to date.
import { Drawing } from "./drawing.js";
import { Curves, LAWS, Law, PANELS } from "./plots.js";

const KEPT = 1500, byId = (id) => document.getElementById(id);
const COEFFICIENTS = [
  ["stiffness", "stiffness σ", "N/mm", 1e-3], ["damping", "damping D", "N s/mm", 1e-3], ["inertia", "mass M", "kg", 1],
  ["k2", "k₂", "1/mm", 1e-3], ["d1", "d₁", "N s/mm", 1e-3], ["d2", "d₂", "N s³/mm³", 1e-9],
  ["force_offset", "F₀", "N", 1], ["coulomb_friction", "d₀", "N", 1],
];
const COUNTS = [["samples_fused", "samples fused"], ["samples_dropped", "dropped"], ["lost", "lost on the bus"],
  ["force_rejected", "force rejected"], ["reset_count", "resets"]];
const NUMBERS = [["stiffness", "stiffness K", "N m/rad", 1], ["damping", "damping D", "N m s/rad", 1], ["inertia", "inertia J", "g m²", 1e3]];

const drawing = new Drawing(byId("drawing"));
const plots = [...PANELS.map((panel) => new Curves(byId("plots"), panel)), ...LAWS.map((law) => new Law(byId("plots"), law))];
let channels = [], columns = new Map(), first = 0, width = 0.02, paused = false, era = null;
let due = false, retry = 250;

function clear() {
  columns = new Map(channels.map((name) => [name, { low: [], high: [] }]));
}

function take(frame) {
  if (frame.hello !== undefined) {
    ({ channels, width } = frame);
    byId("namespace").textContent = frame.hello;
    return clear();
  }
  if (frame.words) show(frame.words);
  if (frame.begin === undefined) return;
  if (frame.era !== era || !columns.get(channels[0]).low.length) { clear(); era = frame.era; first = frame.begin; }
  channels.forEach((name, i) => {
    const column = columns.get(name);
    for (const [key, news] of [["low", frame.low[i]], ["high", frame.high[i]]]) {
      column[key].push(...news);
      if (column[key].length > KEPT) column[key].splice(0, column[key].length - KEPT);
    }
  });
  first = frame.end - columns.get(channels[0]).low.length;
  if (!due && !paused) { due = true; requestAnimationFrame(redraw); }
}

function redraw() {
  due = false;
  const count = columns.get(channels[0])?.low.length ?? 0;
  const shown = Math.min(count, Math.round(byId("window").value / width)), from = count - shown;
  const time = Array.from({ length: shown }, (_, i) => (i - shown + 1) * width);
  for (const plot of plots) plot.draw(time, columns, from);
  document.body.dataset.bins = count;
}

const digits = (value, count = 4) => (value == null ? "–" : String(+value.toPrecision(count)).replace("-", "−"));

function cell(found, factor) {
  const td = document.createElement("td");
  if (!found || found.value == null) { td.textContent = "–"; return td; }
  td.className = found.valid ? "" : "off";
  td.textContent = digits(found.value * factor) + " ";
  td.append(Object.assign(document.createElement("small"), { textContent: `± ${digits(1.96 * found.std * factor, 2)}` }));
  return td;
}

function chip(id, word) {
  const element = byId(id);
  element.dataset.word = word;
  element.querySelector("b").textContent = word;
}

function show(words) {
  if (paused) return;
  const sides = [words.transmission_1, words.transmission_2];
  for (const name of ["transmission_1", "transmission_2", "joint"]) chip(`status_${name}`, words[name].status);
  drawing.update(words);
  const rows = COEFFICIENTS.map(([name, title, unit, factor]) => {
    const row = document.createElement("tr");
    row.id = `row_${name}`;
    row.append(Object.assign(document.createElement("td"), { innerHTML: `${title} <small>${unit}</small>` }));
    for (const side of sides) row.append(cell(side[name] ?? side.coefficients?.[name], factor));
    return row;
  });
  for (const [name, title] of COUNTS) {
    const row = document.createElement("tr");
    row.id = `row_${name}`;
    for (const text of [title, ...sides.map((side) => side[name] ?? "–")]) row.append(Object.assign(document.createElement("td"), { textContent: text }));
    rows.push(row);
  }
  const { delay } = words.joint;
  if (delay?.p50 !== undefined) {
    const row = document.createElement("tr"), text = `p50 ${delay.p50}, p99 ${delay.p99}, max ${delay.max}`;
    row.id = "row_delay";
    row.innerHTML = "<td>delay <small>ms</small></td><td colspan=2></td>";
    row.lastChild.textContent = text;
    rows.push(row);
  }
  document.querySelector("#coefficients tbody").replaceChildren(...rows);
  byId("numbers").replaceChildren(...NUMBERS.map(([name, title, unit, factor]) => number(words.joint[name], title, unit, factor)));
  remarks(words, sides);
}

function number(found, title, unit, factor) {
  const box = Object.assign(document.createElement("div"), { className: found?.valid ? "number" : "number off" });
  box.innerHTML = "<small></small><b></b> <span></span>";
  box.querySelector("small").textContent = title;
  box.querySelector("b").textContent = found ? digits(found.value * factor, 3) : "–";
  box.querySelector("span").textContent = found ? `± ${digits(1.96 * found.std * factor, 2)} ${unit}` : unit;
  return box;
}

function remarks(words, sides) {
  const lines = [];
  sides.forEach((side, i) => {
    const said = [side.reason, ...(side.observability ?? [])].filter(Boolean);
    if (side.reset_count) said.push(`last reset: ${side.reset_reason}`);
    lines.push(...new Set(said.map((text) => `transmission ${i + 1}: ${text}`)));
  });
  if (words.joint.reason) lines.push(`joint: ${words.joint.reason}`);
  for (const [node, text] of Object.entries(words.complaints)) lines.push(`${node}: ${text}`);
  byId("remarks").replaceChildren(...lines.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
}

function connect() {
  const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`), link = byId("link");
  socket.onopen = () => { retry = 250; link.dataset.word = "LIVE"; link.textContent = "live"; era = null; };
  socket.onmessage = (event) => take(JSON.parse(event.data));
  socket.onclose = () => {
    link.dataset.word = "LOST"; link.textContent = "no connection";
    setTimeout(connect, retry);
    retry = Math.min(2 * retry, 4000);
  };
}

byId("pause").onclick = () => { paused = !paused; byId("pause").textContent = paused ? "go on" : "pause"; };
byId("window").onchange = redraw;
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { for (const plot of plots) plot.build(); redraw(); });
connect();
