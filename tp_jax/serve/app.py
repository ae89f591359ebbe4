"""The addresses of the page: what each answers."""

import json
import os
from contextlib import asynccontextmanager
from pathlib import Path

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from tp_jax.errors import InputError
from tp_jax.serve import pages
from tp_jax.serve.answers import answers_of
from tp_jax.serve.diagnoses import REPORT, Diagnoses
from tp_jax.serve.folder import ServedFolder
from tp_jax.serve.guard import REPORT_POLICY, Guard
from tp_jax.serve.jobs import Child, Jobs, diagnosing
from tp_jax.serve.limits import LIMITS, Limits
from tp_jax.serve.names import CAMPAIGN, safe_name
from tp_jax.serve.uploads import receive


def create_app(
    folder: Path,
    token: str,
    *,
    ticket: str = "",
    cookie: str = "tp-jax-serve",
    child: Child = diagnosing,
    limits: Limits = LIMITS,
) -> Starlette:
    """The page as an ASGI application.

    Args:
        folder: that is served; it must be there.
        token: the key that each request needs.
        ticket: stands for it in the address of one visit; empty: none does.
        cookie: its name; another for each port.
        child: makes the command line of a diagnosis.
        limits: numbers that limit and wait.
    """
    served, diagnoses, jobs = ServedFolder(folder), Diagnoses(folder), Jobs(child, limits)

    def page(_: Request) -> Response:
        # A job that ends after this counts as running, and the page asks for its row. The other way
        # round it could be done and have no row.
        job = jobs.status()
        return _html(pages.page(served, diagnoses.rows(), job, limits))

    async def add(request: Request) -> Response:
        name = safe_name(request.path_params["name"])
        if sum(each.is_file() for each in folder.iterdir()) >= limits.files:
            raise InputError(f"The folder holds {limits.files} files already; use another one.")
        over = name == CAMPAIGN
        if over and await run_in_threadpool(lambda: served.by_hand):
            raise HTTPException(
                409, f"{name} is there already and stays as it is; change it in an editor."
            )
        try:
            await receive(request, folder / name, limits, over=over)
        except ClientDisconnect:  # the page was closed; nobody hears an answer
            return Response(status_code=400)
        await run_in_threadpool(served.added, name)
        return PlainTextResponse(f"{name} was added.", 201)

    async def answer(request: Request) -> Response:
        body = await _limited(request, limits.answers)
        try:
            said = json.loads(body)
        except (ValueError, RecursionError):
            raise InputError("The answers are not JSON; load the page anew.") from None
        try:
            await run_in_threadpool(served.write, answers_of(said))
        except InputError as fault:  # half of a number is typed: no fault of the request
            return JSONResponse({"fault": str(fault)})
        return JSONResponse({"fault": ""})

    def diagnose(_: Request) -> Response:
        checked = served.check()
        if checked is None:
            raise InputError("There is no campaign.toml yet; check the recordings first.")
        checked.refuse()
        jobs.start(folder, diagnoses.free())
        return JSONResponse(_job(), 202)

    def job(_: Request) -> Response:
        return JSONResponse(_job())

    def cancel(_: Request) -> Response:
        jobs.cancel()
        return JSONResponse(_job())

    def _job() -> dict:
        return pages.job_state(jobs.status(), served.told)

    def report(request: Request) -> Response:
        file = diagnoses.file(request.path_params["name"], REPORT)
        if file is None:
            raise HTTPException(404, "There is no such report.")
        return FileResponse(
            file, media_type="text/html", headers={"content-security-policy": REPORT_POLICY}
        )

    def compare(request: Request) -> Response:
        a, b = (request.query_params.get(key, "") for key in ("a", "b"))
        return _html(pages.compared(a, b, diagnoses.compared(a, b)))

    @asynccontextmanager
    async def lifespan(_: Starlette):
        yield
        await run_in_threadpool(jobs.close)

    return Starlette(
        routes=[
            Route("/", page),
            Route("/page.css", lambda _: Response(pages.style(), media_type="text/css")),
            Route("/page.js", lambda _: Response(pages.script(), media_type="text/javascript")),
            Route("/recordings/{name:path}", add, methods=["PUT"]),
            Route("/answers", answer, methods=["POST"]),
            Route("/diagnoses", diagnose, methods=["POST"]),
            Route("/diagnoses/{name}/report", report),
            Route("/job", job, methods=["GET"]),
            Route("/job", cancel, methods=["DELETE"]),
            Route("/compare", compare),
        ],
        middleware=[Middleware(Guard, token=token, ticket=ticket, cookie=cookie)],
        exception_handlers={  # type: ignore[arg-type]
            InputError: _refused,
            OSError: _unwritable,
            HTTPException: _failed,
        },
        lifespan=lifespan,
    )


async def _limited(request: Request, most: int) -> bytes:
    """The body of a request, if it is no longer than that many bytes."""
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > most:
            raise HTTPException(413, f"The answers have more than {most} bytes.")
    return bytes(body)


def _html(text: str) -> Response:
    # a file's name need not be text
    return Response(text.encode("utf-8", "backslashreplace"), media_type="text/html")


def _refused(_: Request, fault: Exception) -> Response:
    """Answers a fault that the user can mend with its sentence."""
    return PlainTextResponse(str(fault), 422)


def _unwritable(_: Request, fault: OSError) -> Response:
    """Answers what the file system refuses: a full disk, a folder that may not be written."""
    name = "the folder" if fault.filename is None else Path(os.fsdecode(fault.filename)).name
    return PlainTextResponse(f"Cannot write {name}: {(fault.strerror or str(fault)).lower()}.", 507)


def _failed(_: Request, fault: HTTPException) -> Response:
    return PlainTextResponse(str(fault.detail), fault.status_code, headers=fault.headers)
