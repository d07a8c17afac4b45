'use strict';

/* The page of chases: the report's player, whose episodes the server plays, and a small master
   tournament that grows with the snapshots. */

let player = null;
let offered = '';
let offering = false;
let tournamentOf = '';
let playing = false;

function loadEpisode(run, name) {
  const [predator, predatorRank, prey, preyRank] = name.split('/').map(Number);
  const query = new URLSearchParams({
    predator: run.generations[predator],
    predator_rank: run.ranks[predatorRank],
    prey: run.generations[prey],
    prey_rank: run.ranks[preyRank],
  });
  return answer(`/runs/${run.key}/episode?${query}`);
}

async function offerWatch() {
  const state = JSON.stringify([...runs.values()].map((run) => [run.key, run.snapshots.length]));
  if (document.getElementById('watch').hidden || offering || state === offered) return;
  offering = true;
  try {
    const found = await answer('/watch');
    offered = state;
    document.getElementById('nothing-to-watch').hidden = found.length > 0;
    document.getElementById('watch-content').hidden = !found.length;
    if (!found.length) return;
    if (player) {
      player.update(found);
    } else {
      player = new EpisodePlayer(document.getElementById('player'), loadEpisode);
      player.element('run').addEventListener('change', playTournament);
      window.player = player;
      player.show(found);
    }
    playTournament();
  } catch {
    // The next news asks again.
  } finally {
    offering = false;
  }
}

/* Ask until no cell is missing; the server plays some at a time. */
async function playTournament() {
  const { run } = player;
  const state = `${run.key} ${run.generations.length}`;
  if (playing || document.getElementById('watch').hidden || state === tournamentOf) return;
  playing = true;
  const status = document.getElementById('tournament-status');
  try {
    for (let missing = 1; missing;) {
      const found = await answer(`/runs/${run.key}/tournament`);
      missing = found.missing;
      if (document.getElementById('watch').hidden) break;
      drawChart(document.getElementById('tournament'), found.chart);
      status.textContent = `${run.title}: the best of up to eight generations against the best of each other`
        + (missing ? `; ${missing} cells are still to be played` : '');
      if (player.run.key !== run.key) break;
      if (!missing) tournamentOf = state;
    }
  } catch (error) {
    status.textContent = error.message;
    tournamentOf = state;
  } finally {
    playing = false;
  }
  if (player.run.key !== run.key) playTournament();
}

window.addEventListener('DOMContentLoaded', () => {
  listeners.push(offerWatch);
  document.addEventListener('page', () => {
    offerWatch();
    if (player) playTournament();
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    player?.draw();
    tournamentOf = '';
    if (player) playTournament();
  });
});
