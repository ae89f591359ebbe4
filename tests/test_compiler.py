"""What is asked of the compiler: only what processor and compiler know."""

import os

import pytest

from tp_jax import _processor
from tp_jax._compiler import WIDTH_OPTION, compiler_options


@pytest.fixture
def options(monkeypatch):
    """Sets what the processor can do and the flags, and tells the compiler's options."""

    def found(avx512, flags=""):
        monkeypatch.setattr("tp_jax._compiler.features", lambda: ("avx512f",) if avx512 else ())
        monkeypatch.setattr("jax.default_backend", lambda: "cpu")
        monkeypatch.setenv("XLA_FLAGS", f"{os.environ.get('XLA_FLAGS', '')} {flags}")
        compiler_options.cache_clear()
        return compiler_options()

    yield found
    compiler_options.cache_clear()


def test_full_width_where_the_processor_has_it(options):
    assert options(True) == {WIDTH_OPTION: 512}
    assert options(False) == {}


def test_a_width_of_ones_own_stays(options):
    assert options(True, f"--{WIDTH_OPTION}=128") == {}


def test_an_option_that_the_compiler_does_not_know(options, monkeypatch):
    monkeypatch.setattr("tp_jax._compiler.WIDTH_OPTION", "xla_no_such_option")
    assert options(True) == {}


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("flags\t\t: fpu avx2 avx512f avx512vl", ("avx2", "avx512f", "avx512vl", "fpu")),
        ("Features\t: fp asimd", ("asimd", "fp")),
        ("model\t: 7", ()),
    ],
)
def test_what_a_processor_says_of_itself(tmp_path, line, said):
    file = tmp_path / "cpuinfo"
    file.write_text(f"processor\t: 0\n{line}\nbugs\t\t: avx512f\n", encoding="utf-8")
    assert _processor.features(file) == said
    assert _processor.features(tmp_path / "gone") == ()


def test_another_processor_has_another_name(monkeypatch):
    own = _processor.name.__wrapped__()
    assert own == _processor.name()
    monkeypatch.setattr(_processor, "features", lambda: ("another",))
    assert _processor.name.__wrapped__() != own
