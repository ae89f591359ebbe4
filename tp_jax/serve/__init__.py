"""A local page for recordings: drop files, see what is wrong with them, diagnose, read the report.

    limits                     every number that limits or waits, with its unit and reason
    guard                      who may ask: token, Host, Origin; the headers of every answer
    names -> uploads           a file's name made safe; a file received whole or not at all
    answers                    what a browser sends of the rig and its runs, as `checks` take it
    folder                     the served folder: files, campaign.toml, checks
    jobs -> diagnoses          one at a time, in a process of its own; the list of those made
    pictures -> pages          small pictures of both angles; the HTML of all of it
    -> app -> server           the addresses; the process, bound to this computer alone

Starlette and uvicorn come with the extra `serve`; only `app`, `uploads` and `server` import them.
Templates and styles are in `templates/` and `static/`; the page looks as the report does, by the
report's own stylesheet.
"""
