// Charts: one in a box of the page, or several over one axis that zoom and pan together.

/** How the lines of each role look, and what the legend calls them. */
const ROLES = {
  recorded: { label: "recorded", colour: "--recorded", width: 2.5 },
  declared: { label: "declared model", colour: "--declared", width: 1.25 },
  predicted: { label: "model", colour: "--model", width: 1.25 },
  final: { label: "final model", colour: "--model", width: 1.25 },
  simulated: { label: "simulated", colour: "--recorded", width: 2.5 },
  designed: { label: "designed", colour: "--model", width: 1.75 },
  added: { label: "found effects", colour: "--found", width: 1.5 },
};

const LEFT = 66; // CSS pixels left of the plot, the same in every chart of a stack so that times are below each other

/** Draws horizontal lines at the limits of a chart. */
const drawLevels = levels => chart => {
  const { ctx, bbox } = chart;
  ctx.save();
  ctx.strokeStyle = theme.colour("--limit");
  ctx.setLineDash([6, 5]);
  ctx.lineWidth = 1.5;
  for (const level of levels) {
    const y = Math.round(chart.valToPos(level, "y", true));
    if (y < bbox.top || y > bbox.top + bbox.height) continue;
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
  }
  ctx.restore();
};

/**
 * A chart. `spec`: title, unit, height, x {values, label, log}, lines [{label, colour, width, values, points}], levels, y {log}.
 */
function makeChart(box, spec, more = {}) {
  const ink = theme.colour("--faint");
  const grid = { stroke: theme.colour("--line"), width: 1 };
  const axis = { stroke: ink, grid, ticks: grid, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif" };
  const series = spec.lines.map(line => ({
    label: line.label,
    stroke: line.colour,
    width: line.points ? 0 : line.width,
    paths: line.points ? () => null : undefined,
    points: line.points ? { show: true, size: 4, fill: line.colour, width: 0 } : { show: false },
    value: (_, value) => significant(value),
  }));
  const figure = element("figure", { class: "chart", role: "group", "aria-label": spec.title });
  figure.append(element("figcaption", {}, element("b", {}, spec.title), ` [${spec.unit}]`));
  box.append(figure);
  const levels = spec.levels ?? [];
  const options = {
    width: Math.max(figure.clientWidth, 200),
    height: spec.height,
    padding: [8, 14, 0, 0],
    legend: { live: true, markers: { width: 0, fill: (_, k) => spec.lines[k - 1].colour } },
    cursor: { drag: { x: true, y: false }, points: { size: 6 }, ...more.cursor },
    scales: {
      x: { time: false, distr: spec.x.log ? 3 : 1 },
      y: { distr: spec.log ? 3 : 1, range: spec.log ? undefined : yRange(levels) },
    },
    axes: [
      spec.x.label === null ? { ...axis, size: 0, values: (_, ticks) => ticks.map(() => "") } : { ...axis, size: 28, label: spec.x.label, labelSize: 16, labelGap: 0 },
      { ...axis, size: LEFT, values: (_, ticks) => ticks.map(tick) },
    ],
    series: [{ label: spec.x.name, value: (_, value) => significant(value) }, ...series],
    hooks: { draw: [drawLevels(levels)], ...more.hooks },
  };
  const chart = new uPlot(options, [spec.x.values, ...spec.lines.map(line => line.values)], figure);
  const resize = new ResizeObserver(() => {
    const width = figure.clientWidth;
    if (width > 0 && Math.abs(width - chart.width) > 1) chart.setSize({ width, height: spec.height });
  });
  resize.observe(figure);
  return {
    chart,
    destroy() {
      resize.disconnect();
      chart.destroy();
      figure.remove();
    },
  };
}

/** A tick without trailing zeros. */
function tick(value) {
  if (value === null || value === undefined) return "";
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential().replace("e+", "e") : String(Number(value.toPrecision(6)));
}

/** Room around values and limits. */
const yRange = levels => (_, low, high) => {
  if (low === null || high === null) return [-1, 1];
  const all = [low, high, ...levels];
  const [least, greatest] = [Math.min(...all), Math.max(...all)];
  const room = greatest > least ? 0.06 * (greatest - least) : 0.1 * Math.abs(least) || 1;
  return [least - room, greatest + room];
};

/** Charts over one axis of time: they show the same stretch of it, and the same instant under the pointer. */
class Stack {
  constructor(box, { specs, onTime }) {
    this.times = specs[0].x.values;
    this.onTime = onTime;
    this.linking = false;
    const key = `stack${Stack.count++}`;
    this.members = specs.map(spec =>
      makeChart(box, spec, {
        cursor: { sync: { key } },
        hooks: {
          setScale: [(chart, scale) => scale === "x" && this.link(chart)],
          setCursor: [chart => chart.cursor.idx !== null && chart.cursor.left >= 0 && this.tell(this.times[chart.cursor.idx])],
        },
      }),
    );
    const [first, last] = this.range();
    for (const { chart } of this.members) {
      chart.root.dataset.span = last - first;
      const head = element("div", { class: "playhead", hidden: true });
      chart.over.append(head);
      chart.over.addEventListener("wheel", event => this.wheel(chart, event), { passive: false });
      chart.over.addEventListener("mousedown", event => this.drag(chart, event), { capture: true });
    }
  }

  tell(time) {
    this.onTime?.(time);
  }

  link(source) {
    if (this.linking || !this.members) return;
    this.linking = true;
    const { min, max } = source.scales.x;
    for (const { chart } of this.members) if (chart !== source) chart.setScale("x", { min, max });
    this.linking = false;
    for (const { chart } of this.members ?? []) chart.root.dataset.span = max - min;
    this.mark(this.marked);
  }

  range() {
    const { min, max } = this.members[0].chart.scales.x;
    return [min, max];
  }

  /** Shows the times from `min` to `max`, within those that there are. */
  show(min, max) {
    const [first, last] = [this.times[0], this.times[this.times.length - 1]];
    const width = Math.min(max - min, last - first);
    const start = Math.min(Math.max(min, first), last - width);
    if (width > 0) this.members[0].chart.setScale("x", { min: start, max: start + width });
  }

  zoom(factor, about) {
    const [min, max] = this.range();
    const at = about ?? (min + max) / 2;
    this.show(at - (at - min) * factor, at + (max - at) * factor);
  }

  pan(share) {
    const [min, max] = this.range();
    this.show(min + share * (max - min), max + share * (max - min));
  }

  reset() {
    this.show(this.times[0], this.times[this.times.length - 1]);
  }

  // The wheel alone scrolls the page.
  wheel(chart, event) {
    if (!(event.ctrlKey || event.metaKey || event.shiftKey)) return;
    event.preventDefault();
    const turned = event.deltaY || event.deltaX;
    this.zoom(turned > 0 ? 1.25 : 0.8, chart.posToVal(event.offsetX, "x"));
  }

  // With Shift the pointer moves the axis instead of marking a stretch of it.
  drag(chart, event) {
    if (!event.shiftKey) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    const [min, max] = this.range();
    const start = event.clientX;
    const move = moved => {
      const by = ((start - moved.clientX) / chart.over.clientWidth) * (max - min);
      this.show(min + by, max + by);
    };
    const up = () => {
      document.removeEventListener("mousemove", move);
      document.removeEventListener("mouseup", up);
    };
    document.addEventListener("mousemove", move);
    document.addEventListener("mouseup", up);
  }

  /** Puts the line of the present time into every chart. */
  mark(time) {
    this.marked = time;
    for (const { chart } of this.members) {
      const head = chart.over.querySelector(".playhead");
      const at = time === undefined ? -1 : chart.valToPos(time, "x");
      head.hidden = !(at >= 0 && at <= chart.over.clientWidth);
      head.style.left = `${at}px`;
    }
  }

  destroy() {
    for (const member of this.members) member.destroy();
  }
}
Stack.count = 0;
