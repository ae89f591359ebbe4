"""Who may ask: the key, the names of this computer, and the page's own origin."""

import pytest

from tests.serve.conftest import TOKEN, answers, opened

OWN = "http://127.0.0.1:8000"
PLACES = ("/", "/page.css", "/page.js", "/job", "/diagnoses/diagnosis-1/report", "/compare", "/x")


@pytest.mark.parametrize("place", PLACES)
def test_nothing_without_the_key(folder, place):
    with opened(folder) as client:
        for headers in ({}, {"authorization": "Bearer wrong"}, {"cookie": "tp-jax-serve=wrong"}):
            answer = client.get(place, headers=headers)
            assert answer.status_code == 403
            assert "key" in answer.text
        assert client.get("/?token=wrong").status_code == 403
        assert client.get("/?token=w\u00f6ng").status_code == 403


def test_the_first_visit_keeps_the_key_in_a_strict_cookie(folder):
    with opened(folder) as client:
        answer = client.get(f"/?token={TOKEN}", follow_redirects=False)
        assert answer.status_code == 303
        assert answer.headers["location"] == "/", "the key leaves the address"
        cookie = answer.headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        assert client.get("/").status_code == 200


def test_a_ticket_lets_in_once(folder):
    """Whoever reads it afterwards on the browser's command line stays out."""
    visit = "/?ticket=abc"
    with opened(folder, ticket="abc") as client:
        assert client.get("/?ticket=wrong").status_code == 403
        assert client.get(visit, follow_redirects=False).status_code == 303
        assert client.get("/").status_code == 200
        client.cookies.clear()
        assert client.get(visit).status_code == 403
    with opened(folder) as client:
        assert client.get("/?ticket=").status_code == 403
        assert client.get("/").status_code == 403


@pytest.mark.parametrize("other", ['x={"a":1}', "theme=dark mode", "plain", "a=b=c", ""])
def test_cookies_of_other_programs_do_not_matter(folder, other):
    with opened(folder) as client:
        for cookies in (f"{other}; tp-jax-serve={TOKEN}", f"tp-jax-serve={TOKEN}; {other}"):
            assert client.get("/job", headers={"cookie": cookies}).status_code == 200


def test_the_key_may_stand_in_a_header(folder):
    with opened(folder) as client:
        assert client.get("/job", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:8000", "127.0.0.1.evil.example", ""]
)
def test_a_foreign_name_of_this_computer_is_refused(client, host):
    answer = client.get("/", headers={"host": host})
    assert answer.status_code == 403
    assert "127.0.0.1" in answer.text


@pytest.mark.parametrize("host", ["127.0.0.1:8000", "localhost:8000", "[::1]:8000"])
def test_names_of_this_computer_are_taken(folder, host):
    with opened(folder) as client:
        headers = {"host": host, "authorization": f"Bearer {TOKEN}"}
        assert client.get("/", headers=headers).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "http://127.0.0.1:9000"},
        {"origin": "https://127.0.0.1:8000"},
        {"origin": "null"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    ],
)
@pytest.mark.parametrize(
    ("method", "place"),
    [
        ("PUT", "/recordings/a.csv"),
        ("POST", "/answers"),
        ("POST", "/diagnoses"),
        ("DELETE", "/job"),
    ],
)
def test_other_pages_change_nothing(client, folder, method, place, headers):
    answer = client.request(method, place, content=b"t,phi1\n", headers=headers)
    assert answer.status_code == 403
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("headers", [{}, {"origin": OWN}, {"sec-fetch-site": "same-origin"}])
def test_the_page_itself_does(client, folder, headers):
    answer = client.put("/recordings/a.csv", content=b"t,phi1\n", headers=headers)
    assert answer.status_code == 201
    assert (folder / "a.csv").read_bytes() == b"t,phi1\n"


@pytest.mark.parametrize("place", ["/", "/page.css", "/nothing", "/?token=wrong"])
def test_every_answer_has_a_policy(client, place):
    headers = client.get(place).headers
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self'" in policy
    assert "unsafe-inline" not in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["cross-origin-resource-policy"] == "same-origin"
    assert headers["cache-control"] == "no-store"


def test_answers_for_no_page_are_refused(client):
    for said in (b"no json", b"\xff", b"[" * 100_000):
        answer = client.post("/answers", content=said)
        assert answer.status_code == 422
        assert answer.text.endswith(".")
    for said in (b"[]", b'{"runs": 3}', b'{"runs": {"a.csv": 3}}', b'{"runs": {}}'):
        assert client.post("/answers", content=said).json()["fault"].endswith(".")
    assert client.post("/answers", content=b" " * 300_000).status_code == 413
    assert "no recording" in client.post("/answers", json=answers()).json()["fault"]
