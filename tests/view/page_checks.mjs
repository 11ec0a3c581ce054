// SPDX-License-Identifier: GPL-3.0-or-later
// What holds of the page whatever it shows: nothing runs out of it, and everything has a name.

/** Elements that are wider than the page or run out of it. */
export const overflow = (page) =>
  page.evaluate(() => ({
    wide: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    cut: [
      ...document.querySelectorAll("button, select, input:not([type=range]), h1, h2, p, td, th"),
    ]
      .filter(
        (element) => element.offsetParent && !element.closest(".scroll, .hidden, dialog, .skip"),
      )
      .filter((element) => {
        const box = element.getBoundingClientRect();
        return box.right > innerWidth + 1 || box.left < -1;
      })
      .map((element) => element.id || element.outerHTML.slice(0, 60)),
  }));

const kNamed = [
  "button",
  "link",
  "checkbox",
  "combobox",
  "slider",
  "spinbutton",
  "textbox",
  "application",
  "image",
  "toolbar",
  "region",
  "table",
  "dialog",
];

/** What can be operated or looked at and has no name for screen readers. */
export async function nameless(page) {
  const client = await page.context().newCDPSession(page);
  const { nodes } = await client.send("Accessibility.getFullAXTree");
  return nodes
    .filter(({ ignored, role, name }) => !ignored && kNamed.includes(role?.value) && !name?.value)
    .map(({ role, properties }) => `${role.value} ${JSON.stringify(properties)}`);
}
