// Brings the page to life; without it the page is complete too, with still pictures.

theme.start();
const menu = document.querySelector("nav");
const keepMenuClear = () => {
  const covers = getComputedStyle(menu).position === "sticky" ? menu.offsetHeight : 0;
  document.documentElement.style.setProperty("--menu", `${covers}px`);
};
new ResizeObserver(keepMenuClear).observe(menu);
for (const table of document.querySelectorAll(".scroll > table")) new SortedTable(table);
const exploration = JSON.parse(document.getElementById("exploration").textContent);
const explorerBox = document.getElementById("explorer");
if (explorerBox && exploration.takes.length) new Explorer(explorerBox, exploration);
const mapBox = document.getElementById("correlation-map");
if (mapBox && exploration.correlations) new CorrelationMap(mapBox, exploration.correlations);
window.addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details")) details.open = true;
});
requestAnimationFrame(() => {
  performance.mark("drawn");
  document.documentElement.classList.add("alive");
});
