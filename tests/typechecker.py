"""A plugin of pytest that checks the package's annotations, shapes among them, while tests run.

    python -m pytest -p tests.typechecker

An integer stands for a float where one is asked for, as PEP 484 has it, and NumPy's integers and
booleans, as an index or a comparison of arrays gives them, for Python's. Tests marked `unchecked`
give what no annotation allows, to see the package's own error, and are skipped.
"""

import numpy as np
import pytest
from beartype import BeartypeConf, FrozenDict, beartype
from jaxtyping import install_import_hook

OWN = FrozenDict({int: int | np.integer, bool: bool | np.bool_})
checked = beartype(conf=BeartypeConf(is_pep484_tower=True, hint_overrides=OWN))
install_import_hook("tp_jax", "tests.typechecker.checked")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for each in items:
        if each.get_closest_marker("unchecked"):
            each.add_marker(pytest.mark.skip(reason="gives what no annotation allows"))
