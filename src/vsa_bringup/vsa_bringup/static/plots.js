// Curves over time with their bands, and the two laws of the paper's Fig. 9.
const HEIGHT = 190;
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const pale = (color, share) => `color-mix(in srgb, ${color} ${share}%, transparent)`;

// title, unit, factor from SI, and what to draw: [channel, colour, standard deviation's channel, wide line below]
const both = (name, spread = true) => ["one", "two"].map((color, i) => {
  const channel = `transmission_${i + 1}/${name}`;
  return { channel, color, std: spread ? `${channel}_std` : null, log: name === "stiffness" };
});
const joint = (name) => [{ channel: `joint/${name}`, color: "joint", std: `joint/${name}_std` }];
export const PANELS = [
  ["force", "N", 1, both("force", false)],
  ["force rate", "N/s", 1, both("force_rate", false)],
  ["position: measured (wide) and estimated", "mm", 1e3, [
    ...["one", "two"].map((color, i) => ({ channel: `transmission_${i + 1}/encoder/position`, color, wide: true })),
    ...both("deflection", false)]],
  ["position residual", "µm", 1e6, ["one", "two"].map((color, i) => ({ channel: `transmission_${i + 1}/state/deflection_innovation`, color }))],
  ["velocity", "mm/s", 1e3, both("velocity")],
  ["acceleration", "mm/s²", 1e3, both("acceleration")],
  ["stiffness", "N/mm", 1e-3, both("stiffness")],
  ["damping", "N s/mm", 1e-3, both("damping")],
  ["mass", "kg", 1, both("inertia")],
  ["joint stiffness K", "N m/rad", 1, joint("stiffness")],
  ["joint damping D", "N m s/rad", 1, joint("damping")],
  ["joint inertia J", "g m²", 1e3, joint("inertia")],
];
export const LAWS = [
  ["stiffness against position", "N/mm", "mm", "deflection", "stiffness"],
  ["damping against velocity", "N s/mm", "mm/s", "velocity", "damping"],
];

function card(parent, title, unit) {
  const section = document.createElement("section");
  section.className = "card plot";
  section.innerHTML = "<h2></h2><div></div>";
  section.firstChild.textContent = title;
  section.firstChild.append(Object.assign(document.createElement("span"), { textContent: unit }));
  parent.append(section);
  return section.lastChild;
}

class Shown { // draws only what is on the screen
  constructor(element) {
    this.visible = true;
    new IntersectionObserver((seen) => { this.visible = seen.at(-1).isIntersecting; }, { rootMargin: "100px" }).observe(element);
  }
}

export class Curves extends Shown {
  constructor(parent, [title, unit, factor, lines]) {
    const box = card(parent, title, unit);
    super(box);
    Object.assign(this, { box, factor, lines });
    this.build();
    new ResizeObserver(() => this.plot.setSize({ width: box.clientWidth, height: HEIGHT })).observe(box);
  }

  build() {
    const series = [{}], bands = [];
    for (const line of this.lines) {
      const color = css(`--${line.color}`), at = series.length;
      const thin = { stroke: line.wide ? pale(color, 35) : color, width: line.wide ? 4 : 1.3, points: { show: false } };
      series.push(thin, { ...thin });
      bands.push({ series: [at + 1, at], fill: thin.stroke });
      if (line.std) {
        const none = { stroke: "transparent", width: 0, points: { show: false } };
        series.push(none, { ...none });
        bands.push({ series: [at + 3, at + 2], fill: pale(color, 20) });
      }
    }
    const axis = { stroke: css("--soft"), grid: { stroke: css("--grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui" };
    this.plot?.destroy();
    this.plot = new uPlot({
      width: this.box.clientWidth || 360, height: HEIGHT, series, bands, cursor: { show: false }, legend: { show: false },
      scales: { x: { time: false }, y: { range: (_, low, high) => this.range ?? [low, high] } },
      axes: [{ ...axis, size: 26 }, { ...axis, size: 48 }],
    }, [[]], this.box);
  }

  draw(time, columns, from) {
    if (!this.visible) return;
    const data = [time];
    let lowest = Infinity, highest = -Infinity;
    for (const line of this.lines) {
      const found = columns.get(line.channel), spread = line.std && columns.get(line.std);
      if (!found) { data.push(...Array(line.std ? 4 : 2).fill(time.map(() => null))); continue; }
      const low = found.low.slice(from), high = found.high.slice(from), scale = (v) => (v == null ? null : v * this.factor);
      data.push(low.map(scale), high.map(scale));
      for (let i = 0; i < low.length; i++) if (low[i] != null) { lowest = Math.min(lowest, low[i]); highest = Math.max(highest, high[i]); }
      if (line.std) {
        const std = spread.high.slice(from);
        const below = (v, s) => (line.log ? v * Math.exp(-2 * s / v) : v - 2 * s), above = (v, s) => (line.log ? v * Math.exp(2 * s / v) : v + 2 * s);
        data.push(low.map((v, i) => (v == null ? null : scale(below(v, std[i])))), high.map((v, i) => (v == null ? null : scale(above(v, std[i])))));
      }
    }
    const room = 0.12 * (highest - lowest) || 0.1 * Math.abs(highest) || 1;
    this.range = lowest <= highest ? [(lowest - room) * this.factor, (highest + room) * this.factor] : [0, 1];
    this.plot.setData(data);
  }
}

export class Law extends Shown {
  constructor(parent, [title, unit, unitAcross, across, up]) {
    const box = card(parent, title, `${unit} over ${unitAcross}`);
    const canvas = Object.assign(document.createElement("canvas"), { className: "flat" });
    box.append(canvas);
    super(canvas);
    Object.assign(this, { canvas, across, up });
  }

  build() {}

  draw(time, columns, from) {
    if (!this.visible) return;
    const { canvas } = this, ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = HEIGHT;
    canvas.width = width * ratio; canvas.height = height * ratio;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const sides = [1, 2].map((i) => this.points(columns, `transmission_${i}`, from));
    const all = sides.flat();
    if (!all.length) return;
    const [x0, x1] = extent(all, 0), [y0, y1] = extent(all, 1), left = 48, bottom = height - 26;
    const place = ([x, y]) => [left + (x - x0) / (x1 - x0) * (width - left - 12), bottom - (y - y0) / (y1 - y0) * (bottom - 10)];
    pen.font = "11px system-ui"; pen.fillStyle = css("--soft"); pen.strokeStyle = css("--grid");
    for (let i = 0; i <= 4; i++) {
      const x = x0 + i / 4 * (x1 - x0), y = y0 + i / 4 * (y1 - y0), [px, py] = place([x, y]);
      pen.beginPath(); pen.moveTo(px, 10); pen.lineTo(px, bottom); pen.moveTo(left, py); pen.lineTo(width - 12, py); pen.stroke();
      pen.textAlign = "center"; pen.fillText(+x.toPrecision(2), px, height - 8);
      pen.textAlign = "right"; pen.fillText(+y.toPrecision(2), left - 6, py + 4);
    }
    sides.forEach((points, i) => {
      pen.fillStyle = css(i ? "--two" : "--one");
      for (const point of points) { const [x, y] = place(point); pen.fillRect(x - 1, y - 1, 2.2, 2.2); }
    });
  }

  points(columns, side, from) {
    const x = columns.get(`${side}/${this.across}`), y = columns.get(`${side}/${this.up}`);
    if (!x || !y) return [];
    const found = [];
    for (let i = from; i < x.low.length; i++) {
      if (x.low[i] != null && y.low[i] != null) found.push([500 * (x.low[i] + x.high[i]), 5e-4 * (y.low[i] + y.high[i])]);
    }
    return found;
  }
}

function extent(points, k) {
  let low = Infinity, high = -Infinity;
  for (const point of points) { low = Math.min(low, point[k]); high = Math.max(high, point[k]); }
  const room = 0.06 * (high - low) || 0.1 * Math.abs(high) || 1;
  return [low - room, high + room];
}
