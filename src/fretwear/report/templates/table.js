"use strict";
/* The table of cases: sorted by any column, filtered by values and text. */
(function () {
  const table = document.getElementById("case-table");
  const form = document.querySelector("form.filters");
  const rows = [...table.tBodies[0].rows];
  const heads = [...table.tHead.rows[0].cells];
  const texts = new Intl.Collator("en", { numeric: true });

  /* Rows without a value come last in either direction. */
  function sort(head, direction) {
    const keyed = rows.map((row) => {
      const { dataset, textContent } = row.cells[head.cellIndex];
      return [dataset.value ?? textContent.trim(), row];
    });
    keyed.sort(([a], [b]) =>
      a === "–" || b === "–" ? (a === "–") - (b === "–") : direction * (a - b || texts.compare(a, b))
    );
    table.tBodies[0].append(...keyed.map(([, row]) => row));
    for (const other of heads) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
  }

  for (const head of heads) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    head.setAttribute("aria-sort", "none");
    button.addEventListener("click", () => {
      sort(head, head.getAttribute("aria-sort") === "ascending" ? -1 : 1);
    });
  }

  function filter() {
    const wanted = form.querySelector("input").value.trim().toLowerCase();
    for (const row of rows) {
      const fits = [...form.querySelectorAll("select")].every(
        ({ value, dataset }) => !value || row.cells[dataset.column].textContent === value
      );
      row.hidden = !(fits && row.textContent.toLowerCase().includes(wanted));
    }
    const shown = rows.filter((row) => !row.hidden).length;
    form.querySelector("output").textContent = `${shown} of ${rows.length} shown`;
  }

  form.addEventListener("input", filter);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("reset", () => setTimeout(filter));
  form.hidden = rows.length < 2;
  filter();
})();
