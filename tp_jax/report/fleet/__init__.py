"""Many rigs diagnosed with one call: a table of plain numbers, and a page to sort and filter it.

rows                 a diagnosis, or why there is none -> a row
files                the rows as CSV and as Parquet
page                 the rows as fleet.html, by fleet.html.j2, fleet.css and fleet.js
text                 the rows for a terminal
shared               effects that the rigs share, in sentences
"""
