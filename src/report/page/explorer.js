// The explorer: a recording and a joint are chosen; charts over time, over the motion and over frequency, and the robot, follow.

/** What the panels are called, and how high they are. */
const PANELS = {
  signal: { title: "Signal", height: 250 },
  residual: { title: "Residual, model minus recorded", height: 170 },
  position: { title: "Position", height: 170 },
  speed: { title: "Speed", height: 130 },
  acceleration: { title: "Acceleration", height: 150 },
  error: { title: "Error, model minus recorded", height: 170 },
};

class Explorer {
  constructor(box, { takes, skeleton }) {
    this.box = box;
    this.takes = takes;
    this.skeleton = skeleton;
    this.take = takes[0];
    this.joint = box.dataset.joint || this.take.channels[0]?.name;
    this.stack = null;
    this.others = [];
    this.bar = element("div", { class: "bar" });
    this.charts = element("div", {
      class: "charts",
      tabindex: "0",
      "aria-label": "Charts over time. Arrow keys move along, plus and minus zoom, 0 shows all, space plays.",
      onkeydown: event => this.key(event),
    });
    this.over = element("div", { class: "over" });
    this.side = element("aside", { class: "robot", hidden: true });
    box.append(this.bar, element("div", { class: "stage" }, this.charts, this.side), this.over);
    this.makeBar();
    this.makeSide();
    theme.onChange(() => this.show(true));
    this.load(this.take);
  }

  makeBar() {
    if (this.takes.length > 1) {
      const options = this.takes.map((take, k) => element("option", { value: k }, `${take.name} (${take.kind})`));
      const select = element("select", { onchange: () => this.load(this.takes[select.value]) }, ...options);
      this.bar.append(element("label", { class: "choice" }, "Recording ", select));
    } else {
      this.bar.append(element("span", { class: "choice" }, `${this.take.name} (${this.take.kind})`));
    }
    this.joints = element("div", { class: "chips", role: "group", "aria-label": "Joint" });
    const button = (sign, label, action) => element("button", { type: "button", title: label, "aria-label": label, onclick: action }, sign);
    this.bar.append(
      this.joints,
      element(
        "div",
        { class: "tools", role: "group", "aria-label": "Zoom" },
        button("+", "Zoom in", () => this.stack.zoom(0.5)),
        button("−", "Zoom out", () => this.stack.zoom(2)),
        button("◂", "Earlier", () => this.stack.pan(-0.5)),
        button("▸", "Later", () => this.stack.pan(0.5)),
        button("All", "Show all", () => this.stack.reset()),
      ),
    );
  }

  makeSide() {
    if (!this.skeleton) return;
    this.robot = new Robot(this.side, this.skeleton);
    this.play = element("button", { type: "button", onclick: () => this.toggle() }, "Play");
    this.slider = element("input", { type: "range", min: 0, max: 1000, value: 0, "aria-label": "Time", oninput: () => this.slide() });
    this.clock = element("output", {}, "0 s");
    this.side.append(element("div", { class: "player" }, this.play, this.slider, this.clock));
  }

  load(take) {
    this.take = take;
    if (!take.channels.some(channel => channel.name === this.joint)) this.joint = take.channels[0].name;
    this.joints.replaceChildren(
      ...take.channels.map(({ name }) =>
        element("button", { type: "button", "aria-pressed": String(name === this.joint), onclick: () => this.choose(name) }, name),
      ),
    );
    this.side.hidden = !(this.robot && take.postures);
    if (!this.side.hidden) this.robot.load(take.postures);
    this.show(false);
    this.at(timesOf(take)[0]);
  }

  choose(joint) {
    this.joint = joint;
    for (const chip of this.joints.children) chip.setAttribute("aria-pressed", String(chip.textContent === joint));
    this.show(true);
  }

  /** Draws everything of the present choice; `keep`: over the same stretch of time. */
  show(keep) {
    const range = keep && this.stack ? this.stack.range() : null;
    this.stack?.destroy();
    for (const other of this.others) other.destroy();
    this.over.replaceChildren();
    const channel = this.take.channels.find(({ name }) => name === this.joint);
    const panels = [...new Set(channel.lines.map(line => line.panel))];
    const x = timesOf(this.take);
    const specs = panels.map((panel, k) => this.panel(channel, panel, x, k === panels.length - 1));
    this.stack = new Stack(this.charts, { specs, onTime: time => this.playing || this.at(time) });
    if (range) this.stack.show(...range);
    this.others = [...dependence(this.over, channel), ...spectra(this.over, channel)];
    if (this.robot) this.robot.selected = this.joint;
    if (!this.side.hidden) this.robot.draw();
    this.stack.mark(this.time);
  }

  panel(channel, panel, values, isLast) {
    const lines = channel.lines.filter(line => line.panel === panel);
    const { title, height } = PANELS[panel];
    const start = this.take.start ? `, from ${significant(this.take.start)} s` : "";
    return {
      title: `${title}, ${channel.name}`,
      unit: lines[0].unit,
      height: height + (isLast ? 42 : 0),
      levels: lines.flatMap(line => line.levels ?? []),
      x: { values, name: "t [s]", label: isLast ? `t [s]${start}` : null },
      lines: lines.map(line => ({
        ...ROLES[line.role],
        colour: theme.colour(ROLES[line.role].colour),
        values: valuesOf(line.y),
      })),
    };
  }

  /** Makes `time` the present one. */
  at(time) {
    this.time = time;
    this.stack.mark(time);
    if (this.side.hidden) return;
    const times = timesOf(this.take);
    const span = times[times.length - 1] - times[0] || 1;
    this.slider.value = Math.round((1000 * (time - times[0])) / span);
    this.clock.textContent = `${time.toFixed(2)} s`;
    this.robot.at(time);
  }

  slide() {
    const times = timesOf(this.take);
    this.at(times[0] + (this.slider.value / 1000) * (times[times.length - 1] - times[0]));
  }

  toggle() {
    this.playing = !this.playing;
    this.play.textContent = this.playing ? "Pause" : "Play";
    let before = null;
    const step = now => {
      if (!this.playing) return;
      const [min, max] = this.stack.range();
      const next = this.time + (before === null ? 0 : (now - before) / 1000);
      before = now;
      this.at(next > max || next < min ? min : next);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  key(event) {
    const actions = {
      ArrowLeft: () => this.stack.pan(-0.1),
      ArrowRight: () => this.stack.pan(0.1),
      "+": () => this.stack.zoom(0.5),
      "=": () => this.stack.zoom(0.5),
      "-": () => this.stack.zoom(2),
      0: () => this.stack.reset(),
      " ": () => this.side.hidden || this.toggle(),
    };
    if (!(event.key in actions) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }
}
