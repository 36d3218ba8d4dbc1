// Small parts of the page.

export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "onclick") node.addEventListener("click", value);
    else if (value !== undefined && value !== false) node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children);
  return node;
}

// Buttons of which one is pressed. `choices`: [key, text, tooltip]. Returns the function that presses one.
export function segmented(container, choices, chosen, onChoice) {
  const buttons = new Map();
  const press = (key) => {
    for (const [k, button] of buttons) button.setAttribute("aria-pressed", String(k === key));
  };
  for (const [key, text, title] of choices) {
    const onclick = () => {
      press(key);
      onChoice(key);
    };
    buttons.set(key, element("button", { type: "button", title, "data-key": key, onclick }, text));
  }
  container.replaceChildren(...buttons.values());
  press(chosen);
  return press;
}

// 4 significant digits; powers of ten where a plain number would be long.
export function numberText(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "\u2013";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e5) return String(Number(value.toPrecision(4)));
  const [mantissa, exponent] = value.toExponential(2).split("e");
  return `${mantissa}\u00b710${superscript(Number(exponent))}`;
}

export function superscript(whole) {
  const digits = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";
  return (whole < 0 ? "\u207b" : "") + [...String(Math.abs(whole))].map((d) => digits[d]).join("");
}

export function percentText(value, digits = 2) {
  if (value === null || value === undefined) return "\u2013";
  return `${value >= 0 ? "+" : "\u2212"}${Math.abs(100 * value).toFixed(digits)} %`;
}

export function durationText(seconds) {
  if (seconds < 60) return `${Number(seconds.toPrecision(3))} s`;
  const whole = Math.round(seconds);
  if (whole < 3600) return whole % 60 ? `${Math.floor(whole / 60)} min ${whole % 60} s` : `${whole / 60} min`;
  return `${Math.floor(whole / 3600)} h ${Math.round((whole % 3600) / 60)} min`;
}
