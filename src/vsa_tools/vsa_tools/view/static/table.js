// The texts of the page: status, table, numbers, health, reasons, events.
import { gradient, logFraction } from "./drawing.js";

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

// "0.26746", "0.00027": the value with the digits of its half width, which has two.
export function withInterval(value, half) {
  if (!(half > 0)) return [minus(String(+value.toPrecision(4))), "0"];
  const decimals = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(half))));
  return [minus(value.toFixed(decimals)), half.toFixed(decimals)];
}

const tag = (valid) => make("i", valid ? "tag valid" : "tag", valid ? "valid" : "not valid");

function cell(estimate, factor) {
  if (estimate?.value == null) return make("td", "", "–");
  const [value, half] = withInterval(estimate.value * factor, 1.96 * estimate.std * Math.abs(factor));
  return make("td", estimate.valid ? "" : "off", `${value} `, make("small", "", `± ${half}`), " ", tag(estimate.valid));
}

function row(id, title, unit, ...cells) {
  const element = make("tr", "", make("td", "name", `${title} `, make("small", "", unit)), ...cells);
  element.id = `row_${id}`;
  return element;
}

function lawCell(law) {
  if (!law) return make("td", "", "–");
  return make("td", law.valid ? "name" : "name off", `${law.name} `, tag(law.valid));
}

export function setStatus(id, status, text) {
  const element = byId(id);
  element.dataset.status = status;
  (element.querySelector("b") ?? element).textContent = text ?? status;
}

function number(estimate, title, unit, factor) {
  const box = make("div", estimate?.valid ? "number" : "number off", make("small", "", title));
  if (estimate?.value == null) { box.append(make("b", "", "–"), make("span", "", unit)); return box; }
  const [value, half] = withInterval(estimate.value * factor, 1.96 * estimate.std * factor);
  box.append(make("b", "", value), make("span", "", `± ${half} ${unit} `), tag(estimate.valid));
  return box;
}

function gauge(joint) {
  const box = byId("gauge");
  box.hidden = !(joint.range && joint.stiffness?.valid && joint.stiffness.value > 0);
  if (box.hidden) return;
  const [low, high] = joint.range, text = (value) => `${value.toPrecision(2)}`;
  box.style.background = gradient();
  box.querySelector("i").style.left = `${100 * Math.min(1, Math.max(0, logFraction(joint.stiffness.value, low, high)))}%`;
  box.querySelector(".low").textContent = `soft, ${text(low)}`;
  box.querySelector(".title").textContent = "stiffness K within its reachable range";
  box.querySelector(".high").textContent = `${text(high)} N m/rad, stiff`;
}

function remarks(state, sides) {
  const lines = [];
  sides.forEach((side, i) => {
    const texts = [side.reason, ...(side.observability ?? [])].filter(Boolean);
    if (side.reset_count) texts.push(`last reset: ${side.reset_reason}`);
    lines.push(...new Set(texts.map((text) => `transmission ${i + 1}: ${text}`)));
  });
  if (state.joint.reason) lines.push(`joint: ${state.joint.reason}`);
  for (const [node, text] of Object.entries(state.diagnostics)) lines.push(`${node}: ${text}`);
  if (!lines.length) lines.push("no diagnostics above OK");
  byId("remarks").replaceChildren(...lines.map((text) => make("li", "", text)));
}

function events(list) {
  const clock = (time) => new Date(1000 * time).toLocaleTimeString("en-GB");
  byId("events").replaceChildren(...list.toReversed().map(({ time, source, text, severity, count }) =>
    make("li", severity, make("time", "", clock(time)), ` ${source.replace("_", " ")}: ${text}`, count > 1 ? ` ×${count}` : "")));
}

// Status and reasons for missing data are always updated; the rest unless the page is `paused`.
export function updateTexts(state, paused) {
  const reasons = state.no_data ?? [];
  byId("no_data").hidden = !reasons.length;
  byId("no_data").replaceChildren(make("b", "", "No data"), ...reasons.map((text) => make("span", "", text)));
  for (const name of ["transmission_1", "transmission_2", "joint"]) if (state[name]) setStatus(`status_${name}`, state[name].status);
  if (paused) return;
  const sides = [state.transmission_1, state.transmission_2];
  byId("quantities").replaceChildren(...QUANTITIES.map(([name, title, unit, factor]) =>
    row(name, title, unit, ...sides.map((side) => cell(side[name] ?? side.coefficients?.[name], factor)))),
    row("elastic_law", "elastic law", "", ...sides.map((side) => lawCell(side.elastic_law))));
  sides.forEach((side, i) => { byId("coefficients").dataset[`stamp${i + 1}`] = side.stamp_ns ?? ""; });
  const counts = COUNTS.map(([name, title]) => row(name, title, "", ...sides.map((side) => make("td", "", String(side[name] ?? "–")))));
  const { delay } = state.joint, across = make("td", "", delay?.p50 === undefined ? "–" : `median ${delay.p50}, 99 % ${delay.p99}, maximum ${delay.max}`);
  across.colSpan = 2;
  const modes = row("mode", "mode", "", ...sides.map((side) => make("td", "", side.mode || "–")));
  byId("health").replaceChildren(modes, ...counts, row("delay", "sensor to page", "ms", across));
  byId("numbers").replaceChildren(...NUMBERS.map(([name, title, unit, factor]) => number(state.joint[name], title, unit, factor)));
  byId("numbers").dataset.stamp = state.joint.stamp_ns ?? "";
  gauge(state.joint);
  remarks(state, sides);
  events(state.events);
}
