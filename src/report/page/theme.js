// Light and dark: as the system has it until the reader chooses.

const theme = (() => {
  const root = document.documentElement;
  const system = window.matchMedia("(prefers-color-scheme: dark)");
  const listeners = [];
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : system.matches);
  const tell = () => {
    const button = document.getElementById("theme");
    button.textContent = isDark() ? "Light" : "Dark";
    button.setAttribute("aria-label", `Change to ${isDark() ? "light" : "dark"} colours`);
    for (const listener of listeners) listener();
  };
  return {
    start() {
      const button = document.getElementById("theme");
      button.hidden = false;
      button.addEventListener("click", () => {
        root.dataset.theme = isDark() ? "light" : "dark";
        tell();
      });
      system.addEventListener("change", tell);
      // Paper is light whatever the screen is, and not as wide.
      let before;
      window.addEventListener("beforeprint", () => {
        before = root.dataset.theme;
        root.dataset.theme = "light";
        root.classList.add("paper");
        tell();
      });
      window.addEventListener("afterprint", () => {
        root.classList.remove("paper");
        if (before) root.dataset.theme = before;
        else delete root.dataset.theme;
        tell();
      });
      tell();
    },
    /** Calls back after every change. */
    onChange: listener => listeners.push(listener),
    /** A colour of the style sheet as it is now. */
    colour: name => getComputedStyle(root).getPropertyValue(name).trim(),
  };
})();
