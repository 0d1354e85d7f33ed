// What models lack over the speed, the position and the load, with its mean; and spectra of what is left.

const BINS = 24;
const LEAST_IN_BIN = 4;

/** Means of `y` in equal stretches of `x`, both at the place of the mean of x; not where there are few. */
function binned(x, y) {
  const known = x.map((_, k) => k).filter(k => x[k] !== null && y[k] !== null);
  const low = Math.min(...known.map(k => x[k]));
  const high = Math.max(...known.map(k => x[k]));
  const sums = Array.from({ length: BINS }, () => [0, 0, 0]);
  for (const k of known) {
    const bin = sums[Math.min(BINS - 1, Math.floor((BINS * (x[k] - low)) / (high - low || 1)))];
    bin[0] += 1;
    bin[1] += x[k];
    bin[2] += y[k];
  }
  return sums.filter(([count]) => count >= LEAST_IN_BIN).map(([count, xs, ys]) => [xs / count, ys / count]);
}

/** Points and lines over one axis that has all of their places. */
function merged(points, lines) {
  const xs = [...new Set([...points.flatMap(p => p.x), ...lines.flatMap(l => l.at.map(([x]) => x))])]
    .filter(x => x !== null)
    .sort((a, b) => a - b);
  const place = new Map(xs.map((x, k) => [x, k]));
  const column = pairs => {
    const values = Array(xs.length).fill(undefined); // undefined, unlike null, does not break a line
    for (const [x, y] of pairs) if (x !== null) values[place.get(x)] = y;
    return values;
  };
  return [xs, ...points.map(p => column(p.x.map((x, k) => [x, p.y[k]]))), ...lines.map(l => column(l.at))];
}

/** A chart for each variable: what the first model lacks as points, what was found to explain it, and the mean of what is left. */
function dependence(box, { name, cloud }) {
  if (!cloud) return [];
  const of = role => cloud.of.find(variable => variable.name === role);
  const declared = of("declared") ?? of("predicted");
  const last = of("final") ?? of("predicted");
  const added = of("added");
  box.append(
    element("h3", {}, `What depends on the motion, ${name}`),
    element(
      "p",
      { class: "hint" },
      added
        ? "Points: recorded minus declared model, and what the found effects add to it; where they cover each other, the law explains the misfit. Line: mean of what the final model leaves."
        : "Points: recorded minus model. Line: their mean; where it bends away from zero, the model lacks something that depends on this variable.",
    ),
  );
  const friction = of("friction");
  const speed = cloud.over.find(variable => variable.name === "speed");
  const grid = box.appendChild(element("div", { class: friction && speed ? "grid even" : "grid" }));
  const laws = friction && speed ? [frictionLaw(grid, { speed, friction, last, unit: cloud.unit })] : [];
  const plots = cloud.over.map(({ name: variable, unit, values }) => {
    const x = valuesOf(values);
    const points = [{ x, y: valuesOf(declared.values) }];
    if (added) points.push({ x, y: valuesOf(added.values) });
    const [xs, ...columns] = merged(points, [{ at: binned(x, valuesOf(last.values)) }]);
    const looks = [{ label: added ? "lacking in the declared model" : "lacking in the model", colour: theme.colour("--recorded"), points: true }];
    if (added) looks.push({ label: "found effects", colour: theme.colour("--found"), points: true });
    looks.push({ label: "mean of what is left", colour: theme.colour("--model"), width: 2.5 });
    return makeChart(grid, {
      title: `Over ${variable}`,
      unit: cloud.unit,
      height: 230,
      x: { values: xs, name: `${variable} [${unit}]`, label: `${variable} [${unit}]` },
      lines: looks.map((look, k) => ({ ...look, values: columns[k] })),
    });
  });
  return [...laws, ...plots];
}

/** The fitted friction over speed, and about it what the model leaves: points that stray from the line show another law. */
function frictionLaw(box, { speed, friction, last, unit }) {
  const x = valuesOf(speed.values);
  const law = valuesOf(friction.values);
  const left = valuesOf(last.values);
  const points = [{ x, y: law.map((f, k) => (f === null || left[k] === null ? null : f + left[k])) }];
  const line = x.map((v, k) => [v, law[k]]).filter(([v, f]) => v !== null && f !== null);
  const [xs, scattered, drawn] = merged(points, [{ at: line }]);
  return makeChart(box, {
    title: "Fitted friction over speed",
    unit,
    height: 230,
    x: { values: xs, name: `speed [${speed.unit}]`, label: `speed [${speed.unit}]` },
    lines: [
      { label: "law and what is left", colour: theme.colour("--recorded"), points: true, values: scattered },
      { label: "fitted law", colour: theme.colour("--model"), width: 2.5, values: drawn },
    ],
  });
}

/** One chart: the recorded signal and what models leave of it, over frequency. */
function spectra(box, { name, spectrum }) {
  if (!spectrum) return [];
  box.append(
    element("h3", {}, `Spectra, ${name}`),
    element("p", { class: "hint" }, "A model that has everything leaves a flat line, the noise. Peaks are motion, ripple or resonance that it lacks."),
  );
  const grid = box.appendChild(element("div", { class: "grid wide" }));
  const names = { recorded: "recorded signal", declared: "left by the declared model", predicted: "left by the model", final: "left by the final model" };
  return [
    makeChart(grid, {
      title: "Amplitude spectral density",
      unit: spectrum.unit,
      height: 260,
      log: true,
      x: { values: floats(spectrum.f), name: "f [Hz]", label: "f [Hz]", log: true },
      lines: spectrum.lines.map(({ role, y }) => ({
        ...ROLES[role],
        label: names[role],
        width: 1.5,
        colour: theme.colour(ROLES[role].colour),
        values: floats(y).map(v => (v > 0 ? v : null)),
      })),
    }),
  ];
}
