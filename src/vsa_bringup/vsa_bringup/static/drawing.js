// The joint as it is built: two springs with their dampers, moving rods, tendons, pulley and link.
const NS = "http://www.w3.org/2000/svg";
const WALL = 18, REST = 150, STRETCH = 4200, PULLEY = { x: 395, y: 150, r: 46 }, ROWS = [PULLEY.y - 46, PULLEY.y + 46];

// Soft is blue, stiff is red, on a logarithmic scale [N/m].
export function stiffnessColor(stiffness) {
  const share = Math.min(1, Math.max(0, Math.log10(Math.max(stiffness, 1) / 500) / 2));
  return `hsl(${Math.round(215 - 215 * share)} 75% ${Math.round(50 + 4 * share)}%)`;
}

function make(parent, kind, attributes) {
  const element = document.createElementNS(NS, kind);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
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
    make(svg, "path", { ...soft, d: `M${WALL} 60V240`, "stroke-width": 5 });
    this.sides = ROWS.map((y, i) => ({
      y,
      tendon: make(svg, "path", { ...line, stroke: i ? "var(--two)" : "var(--one)", "stroke-width": 1.8 }),
      spring: make(svg, "path", { ...line, "stroke-width": 3, id: `spring_${i + 1}` }),
      damper: make(svg, "path", soft),
      rod: make(svg, "circle", { r: 6, fill: "var(--card)", stroke: "currentColor", "stroke-width": 2 }),
      label: make(svg, "text", { x: WALL + 12, y: i ? y + 66 : y - 50, fill: "currentColor", "font-size": 15, "font-weight": 600 }),
    }));
    make(svg, "circle", { cx: PULLEY.x, cy: PULLEY.y, r: PULLEY.r, fill: "var(--ground)", stroke: "currentColor", "stroke-width": 2.4 });
    this.link = make(svg, "g", {});
    make(this.link, "path", { ...line, d: `M${PULLEY.x} ${PULLEY.y}h108`, stroke: "var(--joint)", "stroke-width": 13 });
    make(this.link, "circle", { cx: PULLEY.x + 108, cy: PULLEY.y, r: 5, fill: "var(--card)" });
    make(this.link, "path", { ...soft, d: `M${PULLEY.x - PULLEY.r} ${PULLEY.y}h18` });
    make(svg, "circle", { cx: PULLEY.x, cy: PULLEY.y, r: 9, fill: "var(--joint)" });
    this.angle = make(svg, "text", { x: PULLEY.x, y: 285, fill: "var(--soft)", "font-size": 13, "text-anchor": "middle" });
    this.update({ transmission_1: {}, transmission_2: {}, joint: {} });
  }

  update(words) {
    this.sides.forEach((side, i) => {
      const { deflection, stiffness } = words[`transmission_${i + 1}`] ?? {};
      const end = WALL + REST + Math.min(110, Math.max(-60, STRETCH * (deflection?.value ?? 0.008)));
      const below = i ? 1 : -1, damper = side.y + below * 26, middle = WALL + 0.5 * REST;
      side.spring.setAttribute("d", coil(WALL, end, side.y));
      side.spring.setAttribute("stroke", stiffness ? stiffnessColor(stiffness.value) : "var(--idle)");
      side.spring.setAttribute("stroke-opacity", stiffness?.valid ? 1 : 0.5);
      side.damper.setAttribute("d", `M${WALL} ${damper}H${middle}m0 -8v16M${middle + 26} ${damper - 10}h-40m0 20h40M${middle} ${damper}` +
        `M${middle + 26} ${damper - 10}v20V${damper}H${end}V${side.y}`);
      side.tendon.setAttribute("d", `M${end} ${side.y}H${PULLEY.x}`);
      side.rod.setAttribute("cx", end);
      side.rod.setAttribute("cy", side.y);
      side.label.textContent = stiffness ? `${(stiffness.value / 1000).toPrecision(3)} N/mm` : "–";
    });
    const angle = words.joint?.angle;
    this.link.setAttribute("transform", `rotate(${((angle ?? 0) * 180 / Math.PI).toFixed(2)} ${PULLEY.x} ${PULLEY.y})`);
    this.angle.textContent = angle == null ? "" : `angle ${(angle * 180 / Math.PI).toFixed(1)}°`;
  }
}
