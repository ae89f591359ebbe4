"""Settings of JAX: what the user has set stays."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import jax
import pytest

from tp_jax import _processor
from tp_jax._config import (
    SMALL_LOOP,
    cache_folder,
    cache_root,
    compile_small_loops,
    enable_compilation_cache,
    programs_folder,
)
from tp_jax.errors import Notice

OPTION = "xla_cpu_small_while_loop_byte_threshold"
FLAG = f"--xla_backend_extra_options={OPTION}={SMALL_LOOP},xla_cpu_disable_loop_unrolling=true"


@pytest.fixture
def flags(monkeypatch):
    """Sets the variables, makes the setting, and tells the flags."""

    def made(before=None, switch=None):
        for name, value in (("XLA_FLAGS", before), ("TP_JAX_SMALL_LOOPS", switch)):
            if value is None:
                monkeypatch.delenv(name, raising=False)
            else:
                monkeypatch.setenv(name, value)
        compile_small_loops()
        return os.environ.get("XLA_FLAGS")

    return made


@pytest.mark.parametrize("before", [None, ""])
def test_small_loops_where_nothing_is_set(flags, before):
    assert flags(before) == FLAG


def test_small_loops_beside_what_is_set(flags):
    own = "--xla_cpu_enable_fast_math=false --xla_dump_to=dumped"
    assert flags(own) == f"{own} {FLAG}"


@pytest.mark.parametrize("value", [1024, SMALL_LOOP])
def test_small_loops_leave_a_limit_of_ones_own(flags, value):
    own = f"--xla_backend_extra_options={OPTION}={value}"
    assert flags(own) == own


def test_small_loops_a_second_time(flags):
    assert flags(flags()) == FLAG


@pytest.mark.parametrize("switch", ["off", "OFF"])
def test_small_loops_switched_off(flags, switch):
    assert flags(None, switch) is None
    assert flags("--xla_dump_to=dumped", switch) == "--xla_dump_to=dumped"


@pytest.mark.parametrize("switch", ["", "on"])
def test_small_loops_not_switched_off(flags, switch):
    assert flags(None, switch) == FLAG


@pytest.fixture
def caches(tmp_path, monkeypatch):
    """A cache folder of the test's own, in use by JAX."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    cache_folder().mkdir(parents=True)
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(cache_folder()))
    yield tmp_path
    jax.config.update("jax_compilation_cache_dir", before)


def test_programs_lie_beside_the_cache(caches):
    assert programs_folder() == caches / "tp-jax" / _processor.name() / "programs"
    assert programs_folder().is_dir()


def test_programs_are_not_kept_where_the_cache_is_somebody_elses(caches):
    jax.config.update("jax_compilation_cache_dir", str(caches / "theirs"))
    assert programs_folder() is None


def test_programs_are_not_kept_without_a_cache(caches):
    jax.config.update("jax_compilation_cache_dir", None)
    assert programs_folder() is None


def test_programs_are_not_kept_where_no_folder_can_be(caches):
    (caches / "tp-jax" / _processor.name() / "programs").write_text("a file")
    assert programs_folder() is None


def said(code, **variables):
    """What a fresh interpreter says, with these variables alone."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parent.parent,
        env={"PATH": os.environ["PATH"], **variables},
    )
    return done.stdout.split()


def test_using_a_name_changes_nothing_for_others(tmp_path):
    """But 64 bits, without which nothing would be right."""
    code = (
        "import os, jax; before, settings = dict(os.environ), dict(jax.config.values); "
        "import tp_jax as tp; tp.presets.get('bench'); tp.simulate; tp.diagnose; "
        "assert before == dict(os.environ); "
        "print(*[n for n, v in jax.config.values.items() if settings[n] != v])"
    )
    assert said(code, XDG_CACHE_HOME=str(tmp_path)) == ["jax_enable_x64"]
    assert not list(tmp_path.iterdir())


def test_the_one_call_sets_them_before_anything_is_compiled(tmp_path):
    # beside an option of the same kind, which XLA has to take as well
    code = (
        "import tp_jax as tp; tp.enable_compilation_cache(); tp.presets; "
        "import os, jax.numpy as jnp; "
        "assert float(jnp.ones(2).sum()) == 2.0; print(os.environ['XLA_FLAGS'])"
    )
    own = "--xla_backend_extra_options=xla_cpu_other_option=1"
    assert said(code, XLA_FLAGS=own, XDG_CACHE_HOME=str(tmp_path)) == [own, FLAG]


@pytest.mark.parametrize(("before", "wanted"), [("", "nan"), ("import equinox; ", "unset")])
def test_the_cache_in_a_script(before, wanted, tmp_path):
    """Checks that keep programs out of the cache are set aside, where that is still possible."""
    code = (
        f"{before}import os, tp_jax as tp; kept = tp.enable_compilation_cache(); "
        "print(kept, os.environ.get('EQX_ON_ERROR', 'unset'))"
    )
    assert said(code, XDG_CACHE_HOME=str(tmp_path)) == ["True", wanted]
    (folder,) = (tmp_path / "tp-jax").glob("*/xla")
    for each in (folder, folder.parent, folder.parent.parent):
        assert stat.S_IMODE(each.stat().st_mode) == 0o700


@pytest.fixture
def enabled(tmp_path, monkeypatch):
    """Enables the cache in a folder of the test's own, and sets JAX back."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("TP_JAX_CACHE", raising=False)
    before = jax.config.jax_compilation_cache_dir
    yield enable_compilation_cache
    jax.config.update("jax_compilation_cache_dir", before)


@pytest.mark.parametrize("mode", [0o777, 0o770])
@pytest.mark.parametrize("which", ["", "name", "name/xla"])
def test_a_folder_that_others_may_write_to_is_not_used(enabled, which, mode):
    folder = cache_root() / which.replace("name", _processor.name())
    folder.mkdir(parents=True)
    folder.chmod(mode)
    with pytest.warns(Notice, match="others may write to") as told:
        assert not enabled()
    assert str(told[0].message).count(". ") == 0


def test_a_folder_of_somebody_else_is_not_used(enabled, monkeypatch):
    monkeypatch.setattr(os, "getuid", lambda: 12345)
    with pytest.warns(Notice, match="belongs to somebody else"):
        assert not enabled()


@pytest.mark.parametrize("home", ["", "nowhere", "/dev/null"])
def test_a_home_that_is_none(home, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv("TP_JAX_CACHE", raising=False)
    monkeypatch.setenv("HOME", home)
    assert not enable_compilation_cache()
    assert not list(tmp_path.iterdir())
