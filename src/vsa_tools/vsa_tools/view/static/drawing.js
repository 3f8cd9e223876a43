// Drawing of the joint: two springs with dampers, rods, tendons, pulley and link.
const NS = "http://www.w3.org/2000/svg";
const WALL = 18, REST = 150, STRETCH = 5000, PULLEY = { x: 395, y: 132, r: 46 }, ROWS = [PULLEY.y - 46, PULLEY.y + 46];
const SOFT = 300, STIFF = 30000; // ends of the colour scale [N/m]

// Position of a value between two limits on a logarithmic scale, 0 to 1.
export const logFraction = (value, low, high) => Math.log(value / low) / Math.log(high / low);
const color = (at) => `hsl(${Math.round(210 + 150 * at)} 80% ${Math.round(54 - 4 * at)}%)`;
const colorPosition = (stiffness) => Math.min(1, Math.max(0, logFraction(Math.max(stiffness, 1), SOFT, STIFF)));

// Blue is soft, red is stiff; the gradient runs from left to right.
export const stiffnessColor = (stiffness) => color(colorPosition(stiffness));
export const gradient = () => `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(color).join(", ")})`;

function make(parent, kind, attributes, text = "") {
  const element = document.createElementNS(NS, kind);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = text;
  parent.append(element);
  return element;
}

function coil(x0, x1, y) {
  const turns = 9, lead = 12, step = (x1 - x0 - 2 * lead) / (2 * turns);
  let path = `M${x0} ${y}h${lead}`;
  for (let i = 0; i < 2 * turns; i++) path += `L${(x0 + lead + (i + 0.5) * step).toFixed(1)} ${y + (i % 2 ? 11 : -11)}`;
  return path + `L${(x1 - lead).toFixed(1)} ${y}H${x1.toFixed(1)}`;
}

export class Drawing {
  constructor(svg) {
    const line = { fill: "none", stroke: "currentColor", "stroke-width": 2.2, "stroke-linecap": "round", "stroke-linejoin": "round" };
    const soft = { ...line, stroke: "var(--soft)", "stroke-width": 1.6 };
    make(svg, "path", { ...soft, d: `M${WALL} 42V222`, "stroke-width": 5 });
    this.sides = ROWS.map((y, i) => ({
      y,
      tendon: make(svg, "path", { ...line, stroke: i ? "var(--two)" : "var(--one)", "stroke-width": 2 }),
      damper: make(svg, "path", soft),
      spring: make(svg, "path", { ...line, id: `spring_${i + 1}` }),
      rod: make(svg, "circle", { r: 6, fill: "var(--card)", stroke: "currentColor", "stroke-width": 2 }),
      label: make(svg, "text", { x: WALL + 12, y: i ? y + 62 : y - 46, fill: "currentColor", "font-size": 16, "font-weight": 650 }),
    }));
    make(svg, "circle", { cx: PULLEY.x, cy: PULLEY.y, r: PULLEY.r, fill: "var(--ground)", stroke: "currentColor", "stroke-width": 2.4 });
    this.link = make(svg, "g", {});
    make(this.link, "path", { ...line, d: `M${PULLEY.x} ${PULLEY.y}h104`, stroke: "var(--joint)", "stroke-width": 14 });
    make(this.link, "circle", { cx: PULLEY.x + 104, cy: PULLEY.y, r: 5, fill: "var(--card)" });
    make(this.link, "path", { ...soft, d: `M${PULLEY.x - PULLEY.r} ${PULLEY.y}h18` });
    make(svg, "circle", { cx: PULLEY.x, cy: PULLEY.y, r: 9, fill: "var(--joint)" });
    this.angle = make(svg, "text", { x: PULLEY.x, y: ROWS[1] + 24, fill: "var(--soft)", "font-size": 13, "text-anchor": "middle" });
    this.legend(svg);
    this.update({ transmission_1: {}, transmission_2: {}, joint: {} });
  }

  legend(svg) {
    const ramp = make(svg, "linearGradient", { id: "ramp" }), text = { y: 260, fill: "var(--soft)", "font-size": 12 };
    for (const at of [0, 0.25, 0.5, 0.75, 1]) make(ramp, "stop", { offset: at, "stop-color": color(at) });
    make(svg, "text", { ...text, x: WALL }, `soft, ${SOFT / 1000} N/mm`);
    make(svg, "rect", { x: WALL + 98, y: 251, width: 120, height: 9, rx: 4.5, fill: "url(#ramp)" });
    make(svg, "text", { ...text, x: WALL + 228 }, `${STIFF / 1000} N/mm, stiff`);
  }

  update(state) {
    this.sides.forEach((side, i) => {
      const { deflection, stiffness } = state[`transmission_${i + 1}`] ?? {};
      const end = WALL + REST + Math.min(120, Math.max(-60, STRETCH * (deflection?.value ?? 0.008)));
      const below = i ? 1 : -1, damper = side.y + below * 27, middle = WALL + 0.5 * REST;
      side.spring.setAttribute("d", coil(WALL, end, side.y));
      side.spring.setAttribute("stroke", stiffness ? stiffnessColor(stiffness.value) : "var(--idle)");
      side.spring.setAttribute("stroke-width", stiffness ? (2 + 4 * colorPosition(stiffness.value)).toFixed(1) : 3);
      side.spring.setAttribute("stroke-opacity", stiffness?.valid ? 1 : 0.45);
      side.damper.setAttribute("d", `M${WALL} ${damper}H${middle}m0 -8v16M${middle + 26} ${damper - 10}h-40m0 20h40M${middle} ${damper}` +
        `M${middle + 26} ${damper - 10}v20V${damper}H${end}V${side.y}`);
      side.tendon.setAttribute("d", `M${end} ${side.y}H${PULLEY.x}`);
      side.rod.setAttribute("cx", end);
      side.rod.setAttribute("cy", side.y);
      side.label.textContent = stiffness?.value == null ? "–" : `${(stiffness.value / 1000).toPrecision(3)} N/mm${stiffness.valid ? "" : " ?"}`;
    });
    const angle = state.joint?.angle, degrees = (angle ?? 0) * 180 / Math.PI;
    this.link.setAttribute("transform", `rotate(${degrees.toFixed(2)} ${PULLEY.x} ${PULLEY.y})`);
    this.angle.textContent = angle == null ? "" : `angle ${degrees.toFixed(1).replace("-", "−")}°`;
  }
}
