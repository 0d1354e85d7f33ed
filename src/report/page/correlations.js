// Correlations of parameters as a picture: one square for each pair, its colour the correlation, its names under the pointer.

class CorrelationMap {
  constructor(box, { names, rows }) {
    this.names = names;
    this.values = new Int8Array(bytesOf(rows).buffer);
    this.count = names.length;
    this.cell = Math.max(3, Math.min(18, Math.floor(560 / this.count)));
    this.canvas = element("canvas", { tabindex: "0", role: "img", "aria-label": `Correlations of ${this.count} parameters; arrow keys go from pair to pair` });
    this.told = element("p", { class: "told", "aria-live": "polite" }, "Point at a square for its two parameters.");
    box.append(element("div", { class: "map" }, this.canvas), this.told);
    this.canvas.addEventListener("pointermove", event => {
      const { width, height } = this.canvas.getBoundingClientRect();
      this.choose(Math.floor((this.count * event.offsetY) / height), Math.floor((this.count * event.offsetX) / width));
    });
    this.canvas.addEventListener("keydown", event => {
      const by = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
      if (!by) return;
      event.preventDefault();
      const [row, column] = this.chosen ?? [0, 0];
      this.choose(row + by[0], column + by[1]);
    });
    theme.onChange(() => this.draw());
    this.draw();
  }

  choose(row, column) {
    const within = k => Math.min(this.count - 1, Math.max(0, k));
    [row, column] = this.chosen = [within(row), within(column)];
    const value = (this.values[row * this.count + column] / 100).toFixed(2);
    this.told.replaceChildren(element("code", {}, this.names[row]), " and ", element("code", {}, this.names[column]), `: ${value}`);
    this.draw();
  }

  draw() {
    const size = this.count * this.cell;
    const dense = window.devicePixelRatio || 1;
    [this.canvas.width, this.canvas.height] = [size * dense, size * dense];
    this.canvas.style.width = `${size}px`;
    const ctx = this.canvas.getContext("2d");
    ctx.scale(dense, dense);
    const [plus, minus] = [theme.colour("--accent"), theme.colour("--found")];
    ctx.fillStyle = theme.colour("--card");
    ctx.fillRect(0, 0, size, size);
    for (let k = 0; k < this.values.length; k++) {
      const value = this.values[k] / 100;
      ctx.globalAlpha = Math.abs(value);
      ctx.fillStyle = value > 0 ? plus : minus;
      ctx.fillRect((k % this.count) * this.cell, Math.floor(k / this.count) * this.cell, this.cell, this.cell);
    }
    ctx.globalAlpha = 1;
    if (!this.chosen) return;
    ctx.strokeStyle = theme.colour("--ink");
    ctx.lineWidth = 1.5;
    const [row, column] = this.chosen;
    ctx.strokeRect(column * this.cell, row * this.cell, this.cell, this.cell);
  }
}
