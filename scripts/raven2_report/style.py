"""Style of the page, on a computer, on a tablet, on paper. Colours carry nothing that words or shapes do not say too."""

CSS = """
:root { --ink: #1f2933; --soft: #56616c; --line: #d5dae0; --panel: #f6f7f9; --accent: #1d4e89; --warn: #b45309;
  --good: #1b6e53; --bad: #a63603; }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0; background: #e9edf1; color: var(--ink); font: 16px/1.5 "Segoe UI", "Helvetica Neue", "DejaVu Sans",
  Arial,
  sans-serif; }
main { max-width: 1180px; margin: 24px auto; background: #fff; padding: 32px 44px 40px; border-radius: 6px;
  box-shadow: 0 1px 4px rgba(20, 30, 40, .12); }
header { border-bottom: 3px solid var(--accent); padding-bottom: 10px; }
h1 { margin: 0; font-size: 25px; letter-spacing: -.2px; overflow-wrap: anywhere; }
h2 { margin: 34px 0 8px; font-size: 20px; color: var(--accent); }
h3 { margin: 22px 0 6px; font-size: 16px; }
h3 small { font-weight: 400; color: var(--soft); font-size: 13.5px; margin-left: 6px; }
p { margin: 6px 0; max-width: 95ch; overflow-wrap: anywhere; }
.sub { color: var(--soft); font-size: 14px; overflow-wrap: anywhere; }
.summary { margin-top: 16px; }
nav { margin: 10px 0 0; font-size: 14px; display: flex; flex-wrap: wrap; }
nav a { margin-right: 16px; white-space: nowrap; }
a { color: var(--accent); }
.banner { display: flex; gap: 20px; align-items: flex-start; margin: 20px 0 0; padding: 18px 22px; border-radius: 6px;
  border: 2px solid var(--soft); background: var(--panel); }
.banner.passed { border-color: var(--good); background: #edf6f2; }
.banner.failed { border-color: var(--bad); background: #fdf3ee; }
.sign { font-size: 34px; line-height: 1.2; font-weight: 700; width: 1.3em; text-align: center; flex: none; }
.passed .sign { color: var(--good); } .failed .sign { color: var(--bad); }
.headline { font-size: 24px; line-height: 1.3; font-weight: 650; margin: 0 0 4px; max-width: none; }
.banner ul { margin: 2px 0 0; padding-left: 20px; columns: 2; column-gap: 32px; font-size: 14.5px; }
.banner li { break-inside: avoid; }
ol.improve { margin: 8px 0 0; padding: 0; list-style: none; counter-reset: n; display: grid; gap: 10px;
  grid-template-columns: repeat(auto-fit, minmax(250px, 1fr)); }
ol.improve li { counter-increment: n; background: var(--panel); border-left: 4px solid var(--accent);
  padding: 10px 14px; }
ol.improve b { display: block; } ol.improve b::before { content: counter(n) ". "; }
ol.improve span { font-size: 14.5px; color: var(--soft); }
.bandkey svg { width: min(640px, 100%); height: auto; display: block; }
.columns { columns: 2; column-gap: 36px; } .bands { margin: 0 0 10px; } .bands h3 { margin: 8px 0 2px;
  break-after: avoid; }
.bands h3 small { display: block; margin: 0; }
.band { display: grid; grid-template-columns: minmax(0, 1fr) auto 132px 106px; gap: 0 12px; align-items: center;
  padding: 5px 0 6px; border-bottom: 1px solid var(--line); break-inside: avoid; }
.band small { grid-column: 1 / -1; color: var(--soft); font-size: 12.5px; line-height: 1.3; }
.band .what { font-size: 15px; line-height: 1.25; }
.band .value { font-size: 17px; font-weight: 600; text-align: right; white-space: nowrap;
  font-variant-numeric: tabular-nums; }
.band svg { width: 100%; height: auto; display: block; }
.band .mark b { font-size: 14px; white-space: nowrap; } .good .mark b { color: var(--good); }
  .bad .mark b { color: var(--bad); }
.bad .value { color: var(--bad); }
.notice { border-left: 4px solid var(--warn); background: #fdf6ec; padding: 8px 14px; margin: 14px 0; }
.cards { display: grid; grid-template-columns: repeat(4, 1fr); gap: 12px; margin: 16px 0 8px; }
.card { background: var(--panel); border: 1px solid var(--line); border-radius: 5px; padding: 12px 14px;
  min-width: 0; }
.card b { display: block; font-size: 20px; font-weight: 600; }
.card span { color: var(--soft); font-size: 12.5px; }
.card small { display: block; color: var(--soft); font-size: 12px; line-height: 1.35; margin-top: 2px; }
.wide { overflow-x: auto; max-width: 100%; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; }
th { text-align: left; font-weight: 600; color: var(--soft); border-bottom: 2px solid var(--line); padding: 5px 9px;
  vertical-align: bottom; }
td { border-bottom: 1px solid var(--line); padding: 5px 9px; vertical-align: top; }
td small { color: var(--soft); }
.limit, td.v { white-space: nowrap; }
.n { text-align: right; font-variant-numeric: tabular-nums; } td.n { white-space: nowrap; }
.two { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 0 36px; }
.three { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: 8px 20px; }
.three figure { margin: 4px 0; }
figure { margin: 8px 0 14px; break-inside: avoid; }
figure svg { width: 100%; height: auto; display: block; }
svg.scene { background: #fbfcfd; border: 1px solid var(--line); border-radius: 4px; }
svg text { font-family: "Segoe UI", "Helvetica Neue", "DejaVu Sans", Arial, sans-serif; }
#turn:focus { outline: 2px solid var(--accent); }
figcaption { color: var(--soft); font-size: 13px; }
.hazard { border-top: 1px solid var(--line); margin-top: 18px; }
.frames { display: grid; grid-template-columns: repeat(4, minmax(0, 1fr)); gap: 12px; }
.frames figure { margin: 0; }
.frames img { width: 100%; border-radius: 4px; display: block; }
.files { columns: 2; margin-top: 12px; } .files code { white-space: nowrap; }
details { margin-top: 34px; } summary { cursor: pointer; font-size: 20px; font-weight: 700; color: var(--accent); }
details h2 { font-size: 17px; }
code { font: 12.5px "DejaVu Sans Mono", Consolas, monospace; overflow-wrap: anywhere; }
footer { margin-top: 34px; padding-top: 10px; border-top: 1px solid var(--line); color: var(--soft);
  font-size: 12.5px; }
@media screen and (max-width: 960px) { svg.timeline text { font-size: 14.5px; }
  main { margin: 0; padding: 20px 22px; border-radius: 0; }
  .cards, .frames { grid-template-columns: repeat(2, minmax(0, 1fr)); }
  .two { grid-template-columns: minmax(0, 1fr); } .three { grid-template-columns: repeat(2, minmax(0, 1fr)); }
  .columns { columns: 1; } .band { grid-template-columns: minmax(0, 1fr) auto minmax(0, 240px) 106px; } }
@media screen and (max-width: 560px) { .three, .frames, .cards { grid-template-columns: minmax(0, 1fr); }
  .banner { flex-direction: column; gap: 4px; } .banner ul { columns: 1; }
  .band { grid-template-columns: minmax(0, 1fr) auto; } }
@media print { @page { size: A4; margin: 12mm; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  body { background: #fff; font-size: 11px; }
  main { box-shadow: none; margin: 0; padding: 0; max-width: none; }
  h1 { font-size: 19px; } h2 { break-after: avoid; margin-top: 14px; font-size: 15px; }
  h3 { break-after: avoid; font-size: 12.5px; } h3 small { font-size: 10px; } summary { font-size: 15px; }
  .banner { padding: 10px 14px; margin-top: 12px; } .sign { font-size: 24px; } .banner ul { font-size: 11px; }
  .headline { font-size: 18px; } .sub, figcaption { font-size: 10px; } .card b { font-size: 15px; }
  .columns { columns: 1; } .bands h3 small { display: inline; margin-left: 6px; }
  .band { grid-template-columns: minmax(0, 1fr) 90px 220px 84px; padding: 2px 0; }
  .band .what, .band .value { font-size: 12px; } .band .mark b { font-size: 11px; } .band svg { max-height: 22px; }
  .band small, .card small, .card span { font-size: 9.5px; } ol.improve span { font-size: 10.5px; }
  ol.improve { grid-template-columns: repeat(3, 1fr); } ol.improve li { padding: 6px 10px; }
  table { font-size: 9.5px; } td, th { padding: 2px 5px; } .wide { overflow: visible; }
  .card, tr, .frames figure, .hazard { break-inside: avoid; }
  nav, #turn-hint, .files { display: none; } }
"""
