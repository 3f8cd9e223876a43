// Connection to the server, the last half minute of bins, and the displayed time range.
import { Drawing } from "./drawing.js";
import { Curves, LAWS, Law, PANELS, axis } from "./plots.js";
import { setStatus, updateTexts } from "./table.js";

const MAX_BINS = 1500, SILENCE_MS = 2000, byId = (id) => document.getElementById(id);
const drawing = new Drawing(byId("drawing"));
const curves = PANELS.map((panel) => new Curves(byId("plots"), panel)), laws = LAWS.map((law) => new Law(byId("plots"), law));
const plots = [...curves, ...laws];
let socket = null, reconnection = 0, received = 0, newest = null, channels = [], live = new Map(), binS = 0.02, epoch = null, due = false, retry = 250;
let frozen = null; // while paused: a copy of the columns
let zoom = null; // [from, to], seconds before the end of the frozen columns

const paused = () => frozen !== null;
const length = (columns) => columns.get(channels[0])?.low.length ?? 0;

function clear() {
  live = new Map(channels.map((name) => [name, { low: [], high: [] }]));
}

function receive(frame) {
  if (frame.namespace !== undefined) {
    ({ channels, bin_s: binS } = frame);
    location.hash = frame.namespace;
    return clear();
  }
  if (frame.state) {
    received = performance.now();
    listJoints(frame.state.joints);
    show(frame.state);
  }
  if (frame.begin === undefined) return;
  if (frame.epoch !== epoch) { clear(); epoch = frame.epoch; }
  channels.forEach((name, i) => {
    for (const [key, values] of [["low", frame.low[i]], ["high", frame.high[i]]]) {
      const column = live.get(name)[key];
      column.push(...values);
      if (column.length > MAX_BINS) column.splice(0, column.length - MAX_BINS);
    }
  });
  document.body.dataset.end = frame.end;
  if (!due && !paused()) { due = true; requestAnimationFrame(redraw); }
}

function show(state) {
  newest = state;
  updateTexts(state, paused());
  if (!paused()) { drawing.update(state); for (const law of laws) law.update(state); }
}

// A state of which nothing is valid any more.
function silenced(state) {
  const silent = { status: "SILENT", valid: false, reason: "", observability: [], diagnostics: {}, angle: null };
  return JSON.parse(JSON.stringify(state), (key, value) => silent[key] === undefined ? value : silent[key]);
}

function redraw() {
  due = false;
  const columns = frozen ?? live, count = length(columns), last = Math.round(byId("window").value / binS);
  const from = Math.max(0, zoom ? count + Math.floor(zoom[0] / binS) : count - last), to = zoom ? count + Math.ceil(zoom[1] / binS) : count;
  const time = Array.from({ length: Math.max(0, to - from) }, (_, i) => (from + i + 1 - count) * binS);
  for (const plot of plots) plot.draw(time, columns, from, to);
  document.body.dataset.bins = columns.get(channels[0])?.low.reduce((sum, value) => sum + (value != null), 0) ?? 0;
}

function pause(on) {
  frozen = on ? frozen ?? structuredClone(live) : null;
  if (!on) zoom = null;
  byId("pause").textContent = on ? "resume" : "pause";
  byId("zoom_out").hidden = !zoom;
  if (!on && newest) show(newest);
  redraw();
}

axis.zoom = (from, to) => { zoom = [from, to]; pause(true); };
axis.reset = () => { zoom = null; pause(false); };

function listJoints(joints) {
  const select = byId("joint"), here = decodeURIComponent(location.hash.slice(1));
  const options = joints.map((name) => new Option(name || "/", name, false, name === here));
  if ([...select.options].map((one) => one.value).join() !== joints.join()) select.replaceChildren(...options);
}

function connect() {
  clearTimeout(reconnection);
  const scheme = location.protocol === "https:" ? "wss" : "ws", query = location.hash ? `?joint=${location.hash.slice(1)}` : "";
  const current = new WebSocket(`${scheme}://${location.host}/ws${query}`), link = byId("link");
  socket = current;
  let opened = false;
  current.onopen = () => { opened = true; received = performance.now(); retry = 250; setStatus("link", "LIVE", "live"); epoch = null; };
  current.onmessage = (event) => { if (current === socket) receive(JSON.parse(event.data)); };
  current.onclose = () => {
    if (current !== socket) return;
    socket = null;
    setStatus("link", "LOST", "no connection");
    const reason = opened ? "the page's server has ended or is unreachable" : "the page's server does not answer";
    const missing = { no_data: [`${reason}; trying again`] };
    if (newest) show({ ...silenced(newest), ...missing }); else updateTexts(missing, true);
    if (!opened && query) history.replaceState(null, "", location.pathname); // the joint of the address does not exist
    reconnection = setTimeout(connect, retry);
    retry = Math.min(2 * retry, 4000);
  };
}

// A state comes three times a second; a connection without any is lost, also where the browser has not noticed.
function watch() {
  if (socket?.readyState !== WebSocket.OPEN || performance.now() - received < SILENCE_MS) return;
  const silent = socket;
  silent.onclose(); // at once: a peer that does not answer delays the event
  silent.close();
}

byId("joint").onchange = () => {
  location.hash = byId("joint").value;
  newest = null;
  pause(false);
  clear();
  const former = socket;
  socket = null;
  former?.close();
  connect();
};
byId("pause").onclick = () => pause(!paused());
byId("zoom_out").onclick = () => axis.reset();
byId("window").onchange = redraw;
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { for (const plot of plots) plot.build(); redraw(); });
connect();
setInterval(watch, 250);
