// Numbers of the page: 16-bit steps and 32-bit floats in base 64, read when they are first asked for.

const bytesOf = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));

/** 32-bit floats as plain numbers. */
const floats = text => Array.from(new Float32Array(bytesOf(text).buffer));

/** Steps between least and greatest value; null where there is no value. */
const quantised = ({ low, step, data }) =>
  Array.from(new Uint16Array(bytesOf(data).buffer), k => (k === 0xffff ? null : low + step * k));

/** The same function, computed once for each argument. */
function remembered(compute) {
  const known = new Map();
  return argument => {
    if (!known.has(argument)) known.set(argument, compute(argument));
    return known.get(argument);
  };
}

const valuesOf = remembered(quantised);
const timesOf = remembered(take => floats(take.t));

/** Four significant digits, as in the tables. */
function significant(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  return exponent < -4 || exponent > 4 ? value.toExponential(3) : value.toFixed(Math.max(0, 3 - exponent));
}

/** An element with attributes, and children that are elements or text. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, "");
    else if (value !== false && value !== null) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}
