"""scripts/make_site: how it converts links, pictures and names of pages. It must convert this repository's pages."""

import importlib.machinery
import importlib.util
import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
loader = importlib.machinery.SourceFileLoader("make_site", str(ROOT / "scripts/make_site"))
loader_spec = importlib.util.spec_from_loader("make_site", loader)
make_site = importlib.util.module_from_spec(loader_spec)
loader.exec_module(make_site)


def staged(text, name="doc/session.md", others=("doc/wire.md",)):
    """(the converted page for Doxygen, complaints) for a text that replaces one of our pages."""
    site = make_site.Site([name, *others])
    site.texts[name] = text
    site.sections[name] = make_site.sections(text)
    return site.page(name), site.wrong


def test_links_lead_to_pages_and_sections():
    text, wrong = staged("# Title\n\n## A part\n\nSee [there](wire.md), [below](#a-part) and [its frames](wire.md#tcp-frames).\n")
    assert not wrong
    assert text.startswith("# Title {#doc_session}\n\n## A part {#doc_session__a-part}\n")
    assert "[there](@ref doc_wire), [below](@ref doc_session__a-part) and [its frames](@ref doc_wire__tcp-frames)." in text


@pytest.mark.parametrize("link", ["nowhere.md", "wire.md#no-such-part", "#no-such-part", "../config/nothing.yaml"])
def test_a_link_to_nothing_is_an_error(link):
    _, wrong = staged(f"# Title\n\nSee [there]({link}).\n")
    assert len(wrong) == 1 and wrong[0].startswith("doc/session.md: links to ") and link in wrong[0]


def test_a_picture_that_is_missing_is_an_error():
    assert staged("# T\n\n![all](images/nothing.png)\n")[1] == ["doc/session.md: shows images/nothing.png, which is not there"]
    text, wrong = staged("# T\n\n![all](images/plan.png)\n")
    assert '<img src="doc/images/plan.png" alt="all"/>' in text and not wrong


def test_a_page_that_is_named_becomes_a_link():
    assert "([doc/wire.md](@ref doc_wire))" in staged("# T\n\nBytes (`doc/wire.md`).\n")[0]
    assert staged("# T\n\nBytes (`doc/nothing.md`).\n")[1] == ["doc/session.md: names doc/nothing.md, which is not there"]


def test_commands_are_left_alone():
    text, wrong = staged("# T\n\n```\n# no heading\ncat [x](nowhere.md) `doc/nothing.md`\n```\n")
    assert not wrong and "# no heading\ncat [x](nowhere.md) `doc/nothing.md`\n" in text


def test_equal_headings_have_anchors_of_their_own():
    assert make_site.sections("# T\n## Measured\n## Measured\n") == ["t", "measured", "measured-1"]


def test_no_link_of_our_pages_leads_nowhere():
    site = make_site.Site(make_site.pages())
    for name in site.texts:
        site.page(name)
    assert site.wrong == []


def test_every_page_is_on_the_first_one():
    site = make_site.Site(make_site.pages())
    site.page(make_site.START)
    assert site.below == set(site.texts) - {make_site.START}


def test_without_doxygen_it_says_so(tmp_path):
    done = subprocess.run(["/usr/bin/python3", ROOT / "scripts/make_site", "--output", tmp_path], env={"PATH": str(tmp_path)},
                          capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "doxygen is missing" in done.stderr


@pytest.fixture
def elsewhere(tmp_path):
    """All pages in another folder, as a package installs them."""
    shutil.copytree(ROOT / "doc", tmp_path / "doc", ignore=shutil.ignore_patterns("site"))
    for name in make_site.pages():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def checked(root):
    done = subprocess.run([ROOT / "scripts/make_site", "--check", root], env={"PATH": "/nowhere"}, capture_output=True, text=True,
                          check=False)
    return done.returncode, done.stderr


def test_links_of_pages_in_another_place_are_looked_at_there(elsewhere):
    assert checked(elsewhere) == (0, "")
    (elsewhere / "doc/images/plan.png").unlink()
    (elsewhere / "doc/examples/itp_master.py").unlink()  # it is named, but is not a page
    assert checked(elsewhere) == (1, "make_site: doc/session.md: shows images/plan.png, which is not there\n")
    (elsewhere / "SECURITY.md").unlink()
    assert checked(elsewhere) == (1, f"make_site: {elsewhere}/SECURITY.md is not there\n")


def test_pages_without_the_folder_that_they_name_are_found_fault_with(elsewhere):
    """The pages of doc/ are in README's folder."""
    shutil.copytree(elsewhere / "doc", elsewhere, dirs_exist_ok=True)
    shutil.rmtree(elsewhere / "doc")
    assert checked(elsewhere)[0] == 1


@pytest.mark.skipif(shutil.which("doxygen") is None, reason="doxygen is not installed")
def test_doxygen_has_nothing_to_warn_of(tmp_path):
    done = subprocess.run([ROOT / "scripts/make_site", "--output", tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-4000:]
    assert (tmp_path / "doc_wire.html").is_file() and (tmp_path / "doc/images/plan.png").is_file()
    start = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert 'href="doc_tutorials_engineer.html"' in start
    assert not any(sign in start for sign in ("@ref", "@subpage", "{#"))
