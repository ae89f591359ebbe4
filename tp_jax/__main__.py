"""`python -m tp_jax` is `tp-jax`."""

from tp_jax.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
