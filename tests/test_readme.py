"""The README is one page, and its links lead somewhere."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
LINKS = sorted(set(re.findall(r"\]\(([^)\s]+)\)", TEXT)))


def test_it_is_one_page():
    assert len(TEXT.encode()) <= 6000


@pytest.mark.parametrize("link", [link for link in LINKS if "://" not in link])
def test_a_link_leads_somewhere(link):
    path, _, heading = link.partition("#")
    target = ROOT / path
    assert target.exists()
    if heading:
        heads = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE)
        assert heading in {re.sub(r"\W+", "-", head.lower()).strip("-") for head in heads}


def test_its_program_is_the_package_s():
    """It compiles, and every name of `tp` is one."""
    import tp_jax as tp

    block = TEXT.partition("In Python:\n\n")[2].partition("\n\nThe model")[0]
    program = "\n".join(line[4:] for line in block.splitlines())
    compile(program, "README.md", "exec")
    names = set(re.findall(r"\btp\.(\w+)", program))
    assert names == {"enable_compilation_cache", "load_campaign", "diagnose"}
    assert names <= set(tp.__all__)
    methods = set(re.findall(r"\bdiagnosis\.(\w+)", program))
    assert methods >= {"summary", "write_report", "predict"}
    assert methods <= set(dir(tp.Diagnosis)) | set(tp.Diagnosis.__dataclass_fields__)
    (campaign,) = re.findall(r'load_campaign\("([^"]+)"\)', program)
    assert (ROOT / campaign / "campaign.toml").is_file()
