'use strict';

const report = JSON.parse(document.getElementById('report-data').textContent);

async function drawCharts() {
  const charts = JSON.parse(new TextDecoder().decode(await inflate(report.charts)));
  const script = document.createElement('script');
  script.textContent = new TextDecoder().decode(await inflate(report.plotly));
  document.head.append(script);
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries.filter((each) => each.isIntersecting)) {
      seen.unobserve(entry.target);
      drawChart(entry.target, charts[entry.target.dataset.chart]);
    }
  }, { rootMargin: '400px' });
  for (const element of document.querySelectorAll('[data-chart]')) seen.observe(element);
}

async function showPictures() {
  for (const image of document.querySelectorAll('img[data-svg]')) {
    const svg = new Blob([await inflate(image.dataset.svg)], { type: 'image/svg+xml' });
    image.src = URL.createObjectURL(svg);
    delete image.dataset.svg;
  }
}

function makeSortable(table) {
  const headings = [...table.tHead.rows[0].cells];
  headings.forEach((heading, column) => heading.querySelector('button').addEventListener('click', () => {
    const ascending = heading.ariaSort !== 'ascending';
    headings.forEach((each) => { each.ariaSort = 'none'; });
    heading.ariaSort = ascending ? 'ascending' : 'descending';
    const key = (row) => {
      const cell = row.cells[column];
      return 'value' in cell.dataset ? Number(cell.dataset.value) : cell.textContent;
    };
    const compare = (a, b) => {
      const [x, y] = [key(a), key(b)];
      if (typeof x !== typeof y) return typeof x === 'number' ? -1 : 1;
      const order = typeof x === 'number' ? x - y : x.localeCompare(y);
      return ascending ? order : -order;
    };
    table.tBodies[0].append(...[...table.tBodies[0].rows].sort(compare));
  }));
}

document.querySelectorAll('table.sortable').forEach(makeSortable);
window.player = new EpisodePlayer(document.getElementById('player'));
player.show(report.player);
drawCharts();
showPictures();
