"""Receiving a file: whole or not at all, never over a user's own, and not without limit."""

from pathlib import Path

from starlette.exceptions import HTTPException
from starlette.requests import Request

from tp_jax._files import created, replaced
from tp_jax.serve.limits import Limits


async def receive(request: Request, target: Path, limits: Limits, *, over: bool = False) -> None:
    """Writes the body of a request to a new file, or over one that this page wrote.

    Raises:
        HTTPException: 413 it is too large; 409 the file is there already.
    """
    too_large = HTTPException(
        413,
        f"{target.name} has more than {limits.upload / 1e6:g} MB; put it into the folder by hand.",
    )
    said = request.headers.get("content-length", "")
    if said.isdecimal() and int(said) > limits.upload:
        raise too_large
    taken = HTTPException(
        409, f"{target.name} is there already and stays as it is; give the new file another name."
    )
    if not over and (target.exists() or target.is_symlink()):
        raise taken
    try:
        with (replaced if over else created)(target) as part, part.open("wb") as stream:
            size = 0
            async for chunk in request.stream():
                size += len(chunk)
                if size > limits.upload:
                    raise too_large
                stream.write(chunk)
    except FileExistsError:
        raise taken from None
