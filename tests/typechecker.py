"""A plugin of pytest that checks the package's annotations, shapes among them, while tests run.

    python -m pytest -p tests.typechecker

An integer stands for a float where one is asked for, as PEP 484 has it.
"""

from beartype import BeartypeConf, beartype
from jaxtyping import install_import_hook

checked = beartype(conf=BeartypeConf(is_pep484_tower=True))
install_import_hook("tp_jax", "tests.typechecker.checked")
