// SPDX-License-Identifier: GPL-3.0-or-later
// Short forms for the document. Text is written only where it changed, so that nothing is laid out or read aloud anew.

/** Element of index.html. @throws Error  there is none of that id */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html has no element #${id}`);
  return element;
}

export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function setAttribute(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

/** Shows a banner with a sentence; hides it without one. */
export function showBanner(element, sentence) {
  setText(element, sentence ?? '');
  const isHidden = !sentence;
  if (element.hidden !== isHidden) element.hidden = isHidden;
}

/** New element. @param content  texts and elements; null ones are left out */
export function make(tag, attributes = {}, ...content) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...content.filter((part) => part !== null && part !== undefined));
  return element;
}
