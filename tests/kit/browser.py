"""A page of the operator in a browser, with what it requests and what goes wrong in it."""

from __future__ import annotations

from types import SimpleNamespace

from playwright.sync_api import expect

SLOW_MS = 60_000  # of a machine that does other things too


def visit(chromium, address, path="", *, expected_errors=(), **options):
    """A page of a new browser context, with what it requests and what goes wrong in it."""
    context = chromium.new_context(**options)
    context.set_default_timeout(SLOW_MS)
    found = SimpleNamespace(context=context, errors=[], requests=[], sent=[])

    def complain(message):
        if message.type == "error" and not any(each in message.text for each in expected_errors):
            found.errors.append(f"{message.text} {message.location}")

    def note(request):
        found.requests.append(request.url)
        if request.method not in ("GET", "OPTIONS"):
            found.sent.append((request.method, request.url))

    def watch(page):
        page.on("pageerror", lambda error: found.errors.append(str(error)))
        page.on("console", complain)
        page.on("request", note)

    context.on("page", watch)
    found.page = context.new_page()
    found.page.goto(f"{address}/page/{path}")
    return found


def open_view(page, view):
    """A view of the page that is open, by its address."""
    page.evaluate("hash => { location.hash = hash }", f"#/{view}")
    expect(page.locator("#nav a[aria-current=page]")).to_have_attribute("href", f"#/{view.split('/')[0]}")
