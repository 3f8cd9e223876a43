// Curves over time with bands, and the two laws of the paper's Fig. 9; over the stiffness the elastic law with its band.
const HEIGHT = 190;
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const pale = (color, share) => `color-mix(in srgb, ${color} ${share}%, transparent)`;
export const axis = { zoom: () => {}, reset: () => {} }; // handlers of dragging and double clicking

// Title, unit, factor from SI, lines; `interval`: with a standard deviation, `validity`: with a validity flag.
const both = (name, { interval = true, validity = true, wide = false, at = name } = {}) => ["one", "two"].map((color, i) => {
  const channel = `transmission_${i + 1}/${at}`;
  return { channel, color, wide, std: interval && `${channel}_std`, valid: validity && `${channel}_valid`, log: name === "stiffness" };
});
const joint = (name) => [{ channel: `joint/${name}`, color: "joint", std: `joint/${name}_std`, valid: `joint/${name}_valid`, log: name === "stiffness" }];
const bare = { interval: false, validity: false };
export const PANELS = [
  ["joint stiffness K", "N m/rad", 1, joint("stiffness")],
  ["joint damping D", "N m s/rad", 1, joint("damping")],
  ["joint inertia J", "g m²", 1e3, joint("inertia")],
  ["stiffness", "N/mm", 1e-3, both("stiffness")],
  ["damping", "N s/mm", 1e-3, both("damping")],
  ["mass", "kg", 1, both("inertia")],
  ["force", "N", 1, both("force", { interval: false })],
  ["force rate", "N/s", 1, both("force_rate", bare)],
  ["position: measured (wide) and estimated", "mm", 1e3, [...both("position", { ...bare, wide: true, at: "sensor/position" }), ...both("deflection", { interval: false })]],
  ["position residual", "µm", 1e6, both("residual", { ...bare, at: "sensor/residual" })],
  ["velocity", "mm/s", 1e3, both("velocity")],
  ["acceleration", "mm/s²", 1e3, both("acceleration")],
];
export const LAWS = [
  ["stiffness against position", "N/mm", "mm", "deflection", "stiffness"],
  ["damping against velocity", "N s/mm", "mm/s", "velocity", "damping"],
];

function card(parent, title, unit, kind = "") {
  const section = Object.assign(document.createElement("section"), { className: `card plot ${kind}`, innerHTML: "<h2></h2><div></div>" });
  section.firstChild.textContent = title;
  section.firstChild.append(Object.assign(document.createElement("span"), { textContent: unit }));
  parent.append(section);
  return section.lastChild;
}

class OnScreen { // its `visible` is false while it is scrolled away
  constructor(element) {
    this.visible = true;
    new IntersectionObserver((entries) => { this.visible = entries.at(-1).isIntersecting; }, { rootMargin: "100px" }).observe(element);
  }
}

const bounds = (value, std, log) => (log && value > 0 ? [value * Math.exp(-1.96 * std / value), value * Math.exp(1.96 * std / value)]
  : [value - 1.96 * std, value + 1.96 * std]);

export class Curves extends OnScreen {
  constructor(parent, [title, unit, factor, lines]) {
    const box = card(parent, title, unit);
    super(box);
    Object.assign(this, { box, factor, lines, unit, readout: box.parentElement.querySelector("span") });
    this.build();
    new ResizeObserver(() => this.plot.setSize({ width: box.clientWidth, height: HEIGHT })).observe(box);
  }

  build() {
    const series = [{}], bands = [];
    for (const line of this.lines) { // of each line: minimum, maximum, invalid values, interval
      const color = css(`--${line.color}`), at = series.length, hidden = { stroke: "transparent", width: 0, points: { show: false } };
      const stroke = { stroke: line.wide ? pale(color, 35) : color, width: line.wide ? 4 : 1.3, points: { show: false } };
      series.push(stroke, { ...stroke }, { ...stroke, stroke: pale(color, 35), width: 1 }, hidden, { ...hidden });
      bands.push({ series: [at + 1, at], fill: stroke.stroke }, { series: [at + 4, at + 3], fill: pale(color, 22) });
    }
    const style = { stroke: css("--soft"), grid: { stroke: css("--grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui" };
    const minus = (values) => values.map((value) => (value == null ? null : String(+value.toPrecision(6)).replace("-", "−")));
    this.plot?.destroy();
    this.plot = new uPlot({
      width: this.box.clientWidth || 360, height: HEIGHT, series, bands, legend: { show: false },
      cursor: { y: false, points: { show: false }, sync: { key: "time" }, drag: { x: true, y: false, setScale: false }, bind: { dblclick: () => () => axis.reset() } },
      hooks: { setSelect: [(plot) => this.selected(plot)], setCursor: [(plot) => this.read(plot.cursor.idx)] },
      scales: { x: { time: false }, y: { range: (_, low, high) => this.range ?? [low, high] } },
      axes: [{ ...style, size: 26, values: (_, values) => minus(values).map((text) => `${text} s`) }, { ...style, size: 48, values: (_, values) => minus(values) }],
    }, [[]], this.box);
  }

  selected(plot) {
    const { left, width } = plot.select;
    if (width < 8) return;
    axis.zoom(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  }

  read(index) {
    const { data } = this.plot ?? {};
    if (index == null || data?.[0]?.[index] == null) { this.readout.textContent = this.unit; return; }
    const values = this.lines.map((_, i) => data[5 * i + 1][index] ?? data[5 * i + 3][index]).filter((value) => value != null);
    this.readout.textContent = `${data[0][index].toFixed(2)} s: ${values.map((value) => +value.toPrecision(4)).join(", ")} ${this.unit}`.replaceAll("-", "−");
  }

  draw(time, columns, from, to) {
    if (!this.visible) return;
    const data = [time], count = time.length, validRange = [Infinity, -Infinity], all = [Infinity, -Infinity], { factor } = this;
    const extend = (range, low, high) => { range[0] = Math.min(range[0], low); range[1] = Math.max(range[1], high); };
    for (const line of this.lines) {
      const series = columns.get(line.channel), std = line.std && columns.get(line.std).high, valid = line.valid && columns.get(line.valid).low;
      const [low, high, invalid, below, above] = Array.from({ length: 5 }, () => new Array(count).fill(null));
      for (let i = 0, k = from; k < to; i++, k++) {
        const min = series?.low[k], max = series?.high[k];
        if (min == null) continue;
        extend(all, min, max);
        if (valid && !valid[k]) { invalid[i] = 0.5 * (min + max) * factor; continue; }
        extend(validRange, min, max);
        low[i] = min * factor; high[i] = max * factor;
        if (std) { below[i] = bounds(min, std[k], line.log)[0] * factor; above[i] = bounds(max, std[k], line.log)[1] * factor; }
      }
      data.push(low, high, invalid, below, above);
    }
    const [low, high] = validRange[0] <= validRange[1] ? validRange : all, margin = 0.12 * (high - low) || 0.1 * Math.abs(high) || 1;
    this.range = low <= high ? [(low - margin) * factor, (high + margin) * factor] : [0, 1];
    this.plot.setData(data);
  }
}

const tickStep = (span) => { const target = span / 6, power = 10 ** Math.floor(Math.log10(target)); return power * [1, 2, 5, 10].find((one) => one * power >= target); };

export class Law extends OnScreen {
  constructor(parent, [title, unit, unitAcross, across, up]) {
    const box = card(parent, title, `${unit} over ${unitAcross}`, "law");
    const canvas = Object.assign(document.createElement("canvas"), { className: "flat" });
    box.append(canvas);
    super(canvas);
    Object.assign(this, { canvas, across, up, laws: [] });
  }

  // Elastic laws of both transmissions from a state, drawn over the stiffness.
  update(state) {
    this.laws = this.up === "stiffness" ? [1, 2].map((i) => state[`transmission_${i}`]?.elastic_law ?? null) : [];
  }

  build() {}

  draw(time, columns, from, to) {
    if (!this.visible) return;
    const { canvas } = this, ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = width * ratio; canvas.height = height * ratio;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const sides = [1, 2].map((i) => this.points(columns, `transmission_${i}`, from, to)), all = sides.flat();
    const laws = sides.map((points, i) => (points.length && this.laws[i] ? lawPoints(this.laws[i], ...range(points, 0)) : []));
    if (!all.length) return;
    const [x0, x1] = extent(all, 0), [y0, y1] = extent(all, 1), left = 48, bottom = height - 26;
    const across = (x) => left + (x - x0) / (x1 - x0) * (width - left - 12), up = (y) => bottom - (y - y0) / (y1 - y0) * (bottom - 10);
    pen.font = "11px system-ui"; pen.fillStyle = css("--soft"); pen.strokeStyle = css("--grid");
    const line = (...ends) => { pen.beginPath(); pen.moveTo(ends[0], ends[1]); pen.lineTo(ends[2], ends[3]); pen.stroke(); };
    const label = (value, x, y) => pen.fillText(String(+value.toPrecision(6)).replace("-", "−"), x, y);
    pen.textAlign = "center";
    for (let s = tickStep(x1 - x0), x = Math.ceil(x0 / s) * s; x <= x1; x += s) { line(across(x), 10, across(x), bottom); label(x, across(x), height - 8); }
    pen.textAlign = "right";
    for (let s = tickStep(y1 - y0), y = Math.ceil(y0 / s) * s; y <= y1; y += s) { line(left, up(y), width - 12, up(y)); label(y, left - 6, up(y) + 4); }
    sides.forEach((points, i) => {
      const color = css(i ? "--two" : "--one"), ends = [...laws[i].map(([x, , low]) => [x, low]), ...laws[i].toReversed().map(([x, , , high]) => [x, high])];
      const path = (points) => { pen.beginPath(); points.forEach(([x, y], k) => pen[k ? "lineTo" : "moveTo"](across(x), up(y))); };
      pen.save();
      pen.beginPath(); pen.rect(left, 10, width - left - 12, bottom - 10); pen.clip();
      pen.fillStyle = pale(color, this.laws[i]?.valid ? 22 : 10); path(ends); pen.fill();
      pen.strokeStyle = pale(color, this.laws[i]?.valid ? 100 : 35); pen.lineWidth = 1.3; path(laws[i]); pen.stroke();
      pen.restore();
      pen.fillStyle = color;
      for (const [x, y] of points) pen.fillRect(across(x) - 1, up(y) - 1, 2.2, 2.2);
    });
  }

  points(columns, side, from, to) {
    const x = columns.get(`${side}/${this.across}`), y = columns.get(`${side}/${this.up}`), valid = columns.get(`${side}/${this.up}_valid`);
    const points = [];
    for (let i = from; x && i < to; i++) {
      if (x.low[i] != null && y.low[i] != null && valid.low[i]) points.push([500 * (x.low[i] + x.high[i]), 5e-4 * (y.low[i] + y.high[i])]);
    }
    return points;
  }
}

// Position [mm], stiffness [N/mm] and the ends of its 95 % interval along a law: ln stiffness is linear between two knots.
export function lawPoints(law, from, to, count = 60) {
  const { deflection: x, ln_stiffness: y, variance, covariance } = law;
  return Array.from({ length: count + 1 }, (_, k) => {
    const at = 1e-3 * (from + (to - from) * k / count);
    let i = 0;
    while (i < x.length - 2 && at >= x[i + 1]) i++;
    const u = (at - x[i]) / (x[i + 1] - x[i]), w = 1 - u;
    const spread = 1.96 * Math.sqrt(Math.max(0, w * w * variance[i] + 2 * u * w * covariance[i] + u * u * variance[i + 1]));
    const ln = w * y[i] + u * y[i + 1];
    return [1e3 * at, 1e-3 * Math.exp(ln), 1e-3 * Math.exp(ln - spread), 1e-3 * Math.exp(ln + spread)];
  });
}

function range(points, k) {
  let low = Infinity, high = -Infinity;
  for (const point of points) { low = Math.min(low, point[k]); high = Math.max(high, point[k]); }
  return [low, high];
}

function extent(points, k) {
  const [low, high] = range(points, k);
  const margin = 0.06 * (high - low) || 0.1 * Math.abs(high) || 1;
  return [low - margin, high + margin];
}
