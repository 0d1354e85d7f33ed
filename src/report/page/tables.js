// Tables that sort by a column, show rows with a word, and fold where they are long.

const LONG = 24; // rows: about a screen
const FILTERED = 10; // rows from which on a filter is of use

/** What a cell sorts by: its number where it has one, else its text. */
function keyOf(cell) {
  const text = cell?.textContent.trim() ?? "";
  const number = Number.parseFloat(text.replace("−", "-"));
  return { text, number };
}

function compare(a, b) {
  const [x, y] = [Number.isNaN(a.number), Number.isNaN(b.number)];
  if (!x && !y) return a.number - b.number;
  if (x !== y) return x ? 1 : -1;
  return a.text.localeCompare(b.text, undefined, { numeric: true });
}

class SortedTable {
  constructor(table) {
    this.table = table;
    this.body = table.tBodies[0];
    this.rows = [...this.body.rows];
    if (this.rows.length < 3) return;
    this.word = "";
    this.folded = this.rows.length > LONG;
    this.order = this.rows;
    [...table.tHead.rows[0].cells].forEach((head, column) => this.makeHead(head, column));
    const box = table.closest(".scroll");
    if (this.rows.length >= FILTERED) {
      const count = `Filter ${this.rows.length} rows`;
      const filter = element("input", { type: "search", class: "filter", placeholder: count, "aria-label": count });
      filter.addEventListener("input", () => {
        this.word = filter.value.trim().toLowerCase();
        this.show();
      });
      box.before(filter);
    }
    if (this.folded) {
      this.more = element("button", { type: "button", class: "more", onclick: () => this.unfold() }, `Show all ${this.rows.length} rows`);
      box.after(this.more);
      window.addEventListener("beforeprint", () => this.unfold());
    }
    this.show();
  }

  makeHead(head, column) {
    const title = head.textContent;
    if (!title) return;
    head.replaceChildren(element("button", { type: "button", onclick: () => this.sort(head, column) }, title));
  }

  /** Ascending, then descending, then as it was. */
  sort(head, column) {
    const next = { none: "ascending", ascending: "descending", descending: "none" }[head.getAttribute("aria-sort") ?? "none"];
    for (const other of this.table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
    if (next !== "none") head.setAttribute("aria-sort", next);
    const keys = new Map(this.rows.map(row => [row, keyOf(row.cells[column])]));
    const sign = next === "descending" ? -1 : 1;
    this.order = next === "none" ? this.rows : [...this.rows].sort((a, b) => sign * compare(keys.get(a), keys.get(b)));
    this.table.classList.toggle("sorted", next !== "none");
    this.body.append(...this.order);
    this.show();
  }

  unfold() {
    this.folded = false;
    this.more.hidden = true;
    this.show();
  }

  show() {
    let shown = 0;
    for (const row of this.order) {
      const fits = row.textContent.toLowerCase().includes(this.word);
      row.hidden = !fits || (this.folded && !this.word && shown >= LONG - 4);
      shown += fits ? 1 : 0;
    }
  }
}
