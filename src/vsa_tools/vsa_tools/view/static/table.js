// Everything on the page that is text: status, table, numbers, health, reasons, events.
import { gradient, share } from "./drawing.js";

const byId = (id) => document.getElementById(id);
const QUANTITIES = [
  ["stiffness", "stiffness σ", "N/mm", 1e-3], ["damping", "damping D", "N s/mm", 1e-3], ["inertia", "mass M", "kg", 1],
  ["k2", "k₂", "1/mm", 1e-3], ["d1", "d₁", "N s/mm", 1e-3], ["d2", "d₂", "N s³/mm³", 1e-9],
  ["force_offset", "F₀", "N", 1], ["coulomb_friction", "d₀", "N", 1],
];
const COUNTS = [["samples_fused", "samples fused"], ["lost", "lost on the bus"], ["samples_dropped", "dropped"],
  ["force_rejected", "force rejected"], ["deflection_rejected", "position rejected"], ["reset_count", "resets"]];
const NUMBERS = [["stiffness", "stiffness K", "N m/rad", 1], ["damping", "damping D", "N m s/rad", 1], ["inertia", "inertia J", "g m²", 1e3]];

function make(kind, className, ...children) {
  const element = Object.assign(document.createElement(kind), { className });
  element.append(...children);
  return element;
}

const minus = (text) => text.replace("-", "−");

// "0.26746", "0.00027": the value to the two digits of its half width.
export function withInterval(value, half) {
  if (!(half > 0)) return [minus(String(+value.toPrecision(4))), "0"];
  const decimals = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(half))));
  return [minus(value.toFixed(decimals)), half.toFixed(decimals)];
}

const tag = (valid) => make("i", valid ? "tag valid" : "tag", valid ? "valid" : "not valid");

function cell(found, factor) {
  if (found?.value == null) return make("td", "", "–");
  const [value, half] = withInterval(found.value * factor, 1.96 * found.std * Math.abs(factor));
  return make("td", found.valid ? "" : "off", `${value} `, make("small", "", `± ${half}`), " ", tag(found.valid));
}

function row(id, title, unit, ...cells) {
  const found = make("tr", "", make("td", "", `${title} `, make("small", "", unit)), ...cells);
  found.id = `row_${id}`;
  return found;
}

export function chip(id, word, text) {
  const element = byId(id);
  element.dataset.word = word;
  (element.querySelector("b") ?? element).textContent = text ?? word;
}

function number(found, title, unit, factor) {
  const box = make("div", found?.valid ? "number" : "number off", make("small", "", title));
  if (found?.value == null) { box.append(make("b", "", "–"), make("span", "", unit)); return box; }
  const [value, half] = withInterval(found.value * factor, 1.96 * found.std * factor);
  box.append(make("b", "", value), make("span", "", `± ${half} ${unit} `), tag(found.valid));
  return box;
}

function gauge(joint) {
  const box = byId("gauge");
  box.hidden = !(joint.range && joint.stiffness?.value > 0);
  if (box.hidden) return;
  const [low, high] = joint.range, text = (value) => `${value.toPrecision(2)}`;
  box.style.background = gradient();
  box.querySelector("i").style.left = `${100 * Math.min(1, Math.max(0, share(joint.stiffness.value, low, high)))}%`;
  box.querySelector(".low").textContent = `soft, ${text(low)}`;
  box.querySelector(".what").textContent = "stiffness K within what can be set here";
  box.querySelector(".high").textContent = `${text(high)} N m/rad, stiff`;
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
  if (!lines.length) lines.push("no complaint");
  byId("remarks").replaceChildren(...lines.map((text) => make("li", "", text)));
}

function events(found) {
  const clock = (time) => new Date(1000 * time).toLocaleTimeString("en-GB");
  byId("events").replaceChildren(...found.toReversed().map(({ time, who, text, tone, times }) =>
    make("li", tone, make("time", "", clock(time)), ` ${who.replace("_", " ")}: ${text}`, times > 1 ? ` ×${times}` : "")));
}

// Status and the reason for an empty page always; the rest unless the page is `paused`.
export function show(words, paused) {
  const none = words.no_data ?? [];
  byId("no_data").hidden = !none.length;
  byId("no_data").replaceChildren(make("b", "", "No data"), ...none.map((text) => make("span", "", text)));
  for (const name of ["transmission_1", "transmission_2", "joint"]) if (words[name]) chip(`status_${name}`, words[name].status);
  if (paused) return;
  const sides = [words.transmission_1, words.transmission_2];
  byId("quantities").replaceChildren(...QUANTITIES.map(([name, title, unit, factor]) =>
    row(name, title, unit, ...sides.map((side) => cell(side[name] ?? side.coefficients?.[name], factor)))));
  sides.forEach((side, i) => { byId("coefficients").dataset[`stamp${i + 1}`] = side.stamp_ns ?? ""; });
  const counts = COUNTS.map(([name, title]) => row(name, title, "", ...sides.map((side) => make("td", "", String(side[name] ?? "–")))));
  const { delay } = words.joint, across = make("td", "", delay?.p50 === undefined ? "–" : `${delay.p50} median, ${delay.p99} for 99 %, ${delay.max} most`);
  across.colSpan = 2;
  byId("health").replaceChildren(...counts, row("delay", "sensor to page", "ms", across));
  byId("numbers").replaceChildren(...NUMBERS.map(([name, title, unit, factor]) => number(words.joint[name], title, unit, factor)));
  byId("numbers").dataset.stamp = words.joint.stamp_ns ?? "";
  gauge(words.joint);
  remarks(words, sides);
  events(words.events);
}
