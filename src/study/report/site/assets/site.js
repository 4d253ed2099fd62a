// Sorting and filtering; without it every page can be read in full.
"use strict";
(() => {
  const each = (selector, act, root = document) => root.querySelectorAll(selector).forEach(act);

  // Tables sorted by a column; equal rows keep their order.
  const compare = new Intl.Collator("en", { numeric: true, sensitivity: "base" }).compare;
  const sort = (table, column, descending) => {
    const body = table.tBodies[0];
    const keyed = [...body.rows].map((row) => [row.cells[column].textContent.trim(), row]);
    keyed.sort((a, b) => (descending ? -1 : 1) * compare(a[0], b[0]));
    body.append(...keyed.map((pair) => pair[1]));
  };
  each("table[data-sortable]", (table) => {
    [...table.tHead.rows[0].cells].forEach((cell, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      button.append(...cell.childNodes);
      cell.append(button);
      button.addEventListener("click", () => {
        const descending = cell.getAttribute("aria-sort") === "ascending";
        each("th[aria-sort]", (other) => other.removeAttribute("aria-sort"), table);
        cell.setAttribute("aria-sort", descending ? "descending" : "ascending");
        sort(table, column, descending);
      });
    });
  });

  // Ledgers filtered by text and verdict.
  each("form.filter", (form) => {
    const rows = [...document.querySelectorAll("tr[data-verdict]")];
    const text = rows.map((row) => row.textContent.toLowerCase());
    const status = form.querySelector("[role=status]");
    const what = status.textContent.replace(/^\d+ of \d+ /, "");
    const first = form.elements.first;
    const search = form.querySelector("input[type=search]");
    // A search, and a choice of verdicts, are over all rows.
    form.addEventListener("input", (event) => { if (first && event.target !== first) first.checked = false; });
    const update = () => {
      const wanted = search.value.toLowerCase().split(/\s+/);
      const verdicts = new Set();
      each("fieldset input:checked", (box) => verdicts.add(box.value), form);
      rows.forEach((row, i) => {
        const counts = verdicts.has(row.dataset.verdict) && (!first?.checked || "first" in row.dataset);
        row.hidden = !(counts && wanted.every((w) => text[i].includes(w)));
      });
      const shown = rows.filter((row) => !row.hidden).length;
      status.textContent = `${shown} of ${rows.length} ${what}`;
    };
    form.addEventListener("input", update);
    form.addEventListener("submit", (event) => event.preventDefault());
    form.hidden = false;
    update();
    // A link to a row shows it, whatever is filtered.
    const reveal = () => {
      const row = document.getElementById(decodeURIComponent(location.hash.slice(1)));
      if (row && row.hidden) { form.reset(); if (first) first.checked = false; update(); row.scrollIntoView(); }
    };
    addEventListener("hashchange", reveal);
    reveal();
  });
})();
