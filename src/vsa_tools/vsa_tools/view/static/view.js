// Keeps the connection, the last half minute of bins, and what part of it is on the screen.
import { Drawing } from "./drawing.js";
import { Curves, LAWS, Law, PANELS, axis } from "./plots.js";
import { chip, show } from "./table.js";

const KEPT = 1500, byId = (id) => document.getElementById(id);
const drawing = new Drawing(byId("drawing"));
const plots = [...PANELS.map((panel) => new Curves(byId("plots"), panel)), ...LAWS.map((law) => new Law(byId("plots"), law))];
let socket = null, channels = [], live = new Map(), width = 0.02, era = null, due = false, retry = 250;
let frozen = null; // while paused: the columns as they were
let zoom = null; // [from, to], seconds before the end of the frozen columns

const paused = () => frozen !== null;
const length = (columns) => columns.get(channels[0])?.low.length ?? 0;

function clear() {
  live = new Map(channels.map((name) => [name, { low: [], high: [] }]));
}

function take(frame) {
  if (frame.hello !== undefined) {
    ({ channels, width } = frame);
    location.hash = frame.hello;
    return clear();
  }
  if (frame.words) {
    chooseFrom(frame.words.joints);
    show(frame.words, paused());
    if (!paused()) drawing.update(frame.words);
  }
  if (frame.begin === undefined) return;
  if (frame.era !== era) { clear(); era = frame.era; }
  channels.forEach((name, i) => {
    for (const [key, news] of [["low", frame.low[i]], ["high", frame.high[i]]]) {
      const column = live.get(name)[key];
      column.push(...news);
      if (column.length > KEPT) column.splice(0, column.length - KEPT);
    }
  });
  document.body.dataset.end = frame.end;
  if (!due && !paused()) { due = true; requestAnimationFrame(redraw); }
}

function redraw() {
  due = false;
  const columns = frozen ?? live, count = length(columns), last = Math.round(byId("window").value / width);
  const from = Math.max(0, zoom ? count + Math.floor(zoom[0] / width) : count - last), to = zoom ? count + Math.ceil(zoom[1] / width) : count;
  const time = Array.from({ length: Math.max(0, to - from) }, (_, i) => (from + i + 1 - count) * width);
  for (const plot of plots) plot.draw(time, columns, from, to);
  document.body.dataset.bins = columns.get(channels[0])?.low.reduce((sum, value) => sum + (value != null), 0) ?? 0;
}

function pause(on) {
  frozen = on ? frozen ?? structuredClone(live) : null;
  if (!on) zoom = null;
  byId("pause").textContent = on ? "go on" : "pause";
  byId("whole").hidden = !zoom;
  redraw();
}

axis.zoom = (from, to) => { zoom = [from, to]; pause(true); };
axis.whole = () => { zoom = null; pause(false); };

function chooseFrom(joints) {
  const select = byId("joint"), here = decodeURIComponent(location.hash.slice(1));
  const wanted = joints.map((name) => new Option(name || "/", name, false, name === here));
  if ([...select.options].map((one) => one.value).join() !== joints.join()) select.replaceChildren(...wanted);
}

function connect() {
  const scheme = location.protocol === "https:" ? "wss" : "ws", asked = location.hash ? `?joint=${location.hash.slice(1)}` : "";
  const mine = new WebSocket(`${scheme}://${location.host}/ws${asked}`), link = byId("link");
  socket = mine;
  let opened = false;
  mine.onopen = () => { opened = true; retry = 250; chip("link", "LIVE", "live"); era = null; };
  mine.onmessage = (event) => { if (mine === socket) take(JSON.parse(event.data)); };
  mine.onclose = () => {
    if (mine !== socket) return;
    chip("link", "LOST", "no connection");
    const why = opened ? "the page's server has ended or cannot be reached" : "the page's server does not answer";
    show({ no_data: [`${why}; trying again`] }, true);
    if (!opened && asked) history.replaceState(null, "", location.pathname); // the joint in the address is no more
    setTimeout(connect, retry);
    retry = Math.min(2 * retry, 4000);
  };
}

byId("joint").onchange = () => { location.hash = byId("joint").value; pause(false); clear(); socket.onclose = null; socket.close(); connect(); };
byId("pause").onclick = () => pause(!paused());
byId("whole").onclick = () => axis.whole();
byId("window").onchange = redraw;
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { for (const plot of plots) plot.build(); redraw(); });
connect();
