// The robot as lines between its joints, in the posture of one instant, with the way of its tip and the walls around it.

/** x_parent = R x + p, composed. */
const compose = (a, b) => ({
  r: [0, 1, 2].map(i => [0, 1, 2].map(j => a.r[i][0] * b.r[0][j] + a.r[i][1] * b.r[1][j] + a.r[i][2] * b.r[2][j])),
  p: carry(a, b.p),
});
const carry = ({ r, p }, x) => [0, 1, 2].map(i => r[i][0] * x[0] + r[i][1] * x[1] + r[i][2] * x[2] + p[i]);

/** Turned about a unit vector: Rodrigues' formula. */
function turned([x, y, z], angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  const v = 1 - c;
  return [
    [c + x * x * v, x * y * v - z * s, x * z * v + y * s],
    [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
    [z * x * v - y * s, z * y * v + x * s, c + z * z * v],
  ];
}

const IDENTITY = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

/** Frames of all links at positions q, and the points at the ends. */
function forward(skeleton, q) {
  const frames = [];
  skeleton.joints.forEach((joint, j) => {
    const before = joint.parent === null ? { r: IDENTITY, p: [0, 0, 0] } : frames[joint.parent];
    const slides = joint.motion === "prismatic";
    const moved = {
      r: slides ? IDENTITY : turned(joint.axis, q[j]),
      p: slides ? joint.axis.map(a => a * q[j]) : [0, 0, 0],
    };
    frames.push(compose(compose(before, { r: joint.pose.rotation, p: joint.pose.translation }), moved));
  });
  return { frames, tips: skeleton.tips.map(tip => carry(frames[tip.joint], tip.at)) };
}

/** Where the two ends of everything that closes a loop are. */
const places = ({ closures = [] }, frames) =>
  closures.map(({ ends }) => ends.map(({ link, point }) => (link === null ? point : carry(frames[link], point))));

class Robot {
  constructor(box, skeleton) {
    this.skeleton = skeleton;
    this.yaw = -0.9;
    this.pitch = 0.35;
    this.canvas = element("canvas", {
      tabindex: "0",
      role: "img",
      "aria-label": "The robot in the posture of the time under the pointer; arrow keys turn the view",
    });
    box.append(this.canvas);
    this.canvas.addEventListener("pointerdown", event => this.turn(event));
    this.canvas.addEventListener("keydown", event => {
      const by = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
      if (!by) return;
      event.preventDefault();
      this.view(this.yaw + by[0], this.pitch + by[1]);
    });
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  view(yaw, pitch) {
    this.yaw = yaw;
    this.pitch = Math.min(1.5, Math.max(-0.4, pitch));
    this.draw();
  }

  turn(event) {
    const [x, y, yaw, pitch] = [event.clientX, event.clientY, this.yaw, this.pitch];
    this.canvas.setPointerCapture(event.pointerId);
    const move = e => this.view(yaw + (e.clientX - x) / 120, pitch + (e.clientY - y) / 120);
    this.canvas.addEventListener("pointermove", move);
    this.canvas.addEventListener("pointerup", () => this.canvas.removeEventListener("pointermove", move), { once: true });
  }

  /** Postures of a take; the view fits all of them. */
  load(postures) {
    this.t = floats(postures.t);
    this.q = postures.q.map(valuesOf);
    const stride = Math.ceil(this.t.length / 400);
    this.way = [];
    const reach = [];
    for (let k = 0; k < this.t.length; k += stride) {
      const { frames, tips } = forward(this.skeleton, this.q.map(q => q[k] ?? 0));
      this.way.push(tips[0] ?? frames[frames.length - 1].p);
      reach.push([0, 0, 0], ...frames.map(f => f.p), ...tips, ...places(this.skeleton, frames).flat());
    }
    const low = [0, 1, 2].map(i => Math.min(...reach.map(p => p[i])));
    const high = [0, 1, 2].map(i => Math.max(...reach.map(p => p[i])));
    this.centre = low.map((l, i) => (l + high[i]) / 2);
    this.radius = Math.max(0.05, ...reach.map(p => Math.hypot(...p.map((x, i) => x - this.centre[i]))));
    this.floor = Math.min(0, low[2]);
    this.time = this.t[0];
    this.draw();
  }

  at(time) {
    this.time = time;
    this.draw();
  }

  /** Positions between the two postures about the present time. */
  posture() {
    let low = 0;
    let high = this.t.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.t[middle] <= this.time) low = middle;
      else high = middle;
    }
    const share = high > low ? Math.min(1, Math.max(0, (this.time - this.t[low]) / (this.t[high] - this.t[low]))) : 0;
    return this.q.map(q => (q[low] ?? 0) * (1 - share) + (q[high] ?? 0) * share);
  }

  draw() {
    if (!this.t) return;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const dense = window.devicePixelRatio || 1;
    [this.canvas.width, this.canvas.height] = [width * dense, height * dense];
    const ctx = this.canvas.getContext("2d");
    ctx.scale(dense, dense);
    ctx.lineCap = ctx.lineJoin = "round";
    const scale = (0.46 * Math.min(width, height)) / this.radius;
    const [sy, cy, sp, cp] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    const project = point => {
      const [x, y, z] = point.map((value, i) => value - this.centre[i]);
      const [along, depth] = [cy * x - sy * y, sy * x + cy * y];
      return [width / 2 + scale * along, height / 2 - scale * (cp * z + sp * depth)];
    };
    const path = points => {
      ctx.beginPath();
      points.forEach((point, k) => (k ? ctx.lineTo(...project(point)) : ctx.moveTo(...project(point))));
    };
    this.ground(ctx, path);
    for (const wall of this.skeleton.walls ?? []) this.wall(ctx, path, wall);
    ctx.strokeStyle = theme.colour("--found");
    ctx.globalAlpha = 0.55;
    ctx.lineWidth = 1.25;
    path(this.way);
    ctx.stroke();
    ctx.globalAlpha = 1;
    const { frames, tips } = forward(this.skeleton, this.posture());
    const { joints, closures = [] } = this.skeleton;
    const ends = places(this.skeleton, frames);
    const onLink = (link, place) => [link === null ? [0, 0, 0] : frames[link].p, place];
    const bones = joints.map((joint, j) => onLink(joint.parent, frames[j].p)).filter((_, j) => !joints[j].free);
    bones.push(...this.skeleton.tips.map((tip, k) => onLink(tip.joint, tips[k])));
    closures.forEach((closure, c) => {
      bones.push(ends[c], ...ends[c].map((place, k) => onLink(closure.ends[k].link, place)));
    });
    for (const [colour, line] of [["--card", 9], ["--bone", 6]]) {
      ctx.strokeStyle = theme.colour(colour);
      ctx.lineWidth = line;
      for (const bone of bones) {
        path(bone);
        ctx.stroke();
      }
    }
    frames.forEach((frame, j) => {
      if (joints[j].free) return;
      const chosen = joints[j].name === this.selected;
      ctx.beginPath();
      ctx.arc(...project(frame.p), chosen ? 7 : 4.5, 0, 2 * Math.PI);
      ctx.fillStyle = theme.colour(chosen ? "--accent" : "--card");
      ctx.strokeStyle = theme.colour(chosen ? "--accent" : "--bone");
      ctx.lineWidth = 2;
      ctx.fill();
      ctx.stroke();
    });
  }

  /** A grid on the floor. */
  ground(ctx, path) {
    ctx.strokeStyle = theme.colour("--line");
    ctx.lineWidth = 1;
    const step = this.radius / 3;
    for (let k = -3; k <= 3; k++) {
      const at = k * step;
      for (const ends of [[[at, -this.radius], [at, this.radius]], [[-this.radius, at], [this.radius, at]]]) {
        path(ends.map(([x, y]) => [x, y, this.floor]));
        ctx.stroke();
      }
    }
  }

  /** A square of the plane normal · p = offset about the point that is nearest to the middle of the view. */
  wall(ctx, path, { normal, offset }) {
    const size = Math.hypot(...normal);
    const n = normal.map(x => x / size);
    const gap = offset / size - n.reduce((sum, x, i) => sum + x * this.centre[i], 0);
    const foot = this.centre.map((c, i) => c + gap * n[i]);
    const other = Math.abs(n[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const u = cross(n, other);
    const length = Math.hypot(...u);
    const [a, b] = [u.map(x => x / length), cross(n, u.map(x => x / length))];
    const corner = (s, t) => foot.map((f, i) => f + 0.9 * this.radius * (s * a[i] + t * b[i]));
    path([corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1), corner(-1, -1)]);
    ctx.fillStyle = ctx.strokeStyle = theme.colour("--limit");
    ctx.globalAlpha = 0.09;
    ctx.fill();
    ctx.globalAlpha = 0.5;
    ctx.stroke();
    ctx.globalAlpha = 1;
  }
}
