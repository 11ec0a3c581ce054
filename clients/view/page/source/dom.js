// SPDX-License-Identifier: GPL-3.0-or-later
// Small helpers for the document. Texts always go in as text, never as markup.

export const by_id = (id) => document.getElementById(id);

/** An element with properties and children; a string child is a text. */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in element && !name.includes("-")) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

/** Writes a text only where it differs, so that screen readers and layout are left in peace. */
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Calls `action` at most once in `period` ms; the last call is never lost. */
export function throttled(action, period) {
  let last = -Infinity;
  let timer = null;
  const run = () => {
    timer = null;
    last = performance.now();
    action();
  };
  return () => {
    if (timer !== null) return;
    timer = setTimeout(run, Math.max(0, last + period - performance.now()));
  };
}

/** The value of a CSS variable now, in the present theme. */
export function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Says a sentence to screen readers, politely; the same one at most every two seconds. */
const said = new Map();
export function announce(text) {
  const now = performance.now();
  if (now - (said.get(text) ?? -Infinity) < 2000) return;
  said.clear();
  said.set(text, now);
  write(by_id("announcements"), text);
}
