# SPDX-License-Identifier: GPL-2.0-or-later
"""What rocrate-validator says of a crate, a line an issue, without a network: ``python validate_crate.py FOLDER``.

Its one look-up, the context of RO-Crate, gets the copy that the package rocrate carries.
"""

import io
import sys
import urllib.response
from email.message import Message
from importlib.resources import files

import rdflib._networking
import rdflib.parser
import requests
import urllib3
from rocrate_validator import models, services

CONTEXT = (files("rocrate") / "data" / "ro-crate.jsonld").read_bytes()


def opened(request, *_, **__):
    """The context in place of what is behind an address."""
    head = Message()
    head["Content-Type"] = "application/ld+json"
    return urllib.response.addinfourl(io.BytesIO(CONTEXT), head, getattr(request, "full_url", request), 200)


def sent(adapter, request, **_):
    """As `opened`, for requests and its cache."""
    head = {"Content-Type": "application/ld+json"}
    url = request.url
    raw = urllib3.HTTPResponse(io.BytesIO(CONTEXT), head, 200, preload_content=False, request_url=url)
    return adapter.build_response(request, raw)


rdflib._networking._urlopen = rdflib.parser._urlopen = opened
requests.adapters.HTTPAdapter.send = sent
asked = services.ValidationSettings(
    rocrate_uri=models.URI(sys.argv[1]),
    profile_identifier="ro-crate-1.1",
    requirement_severity=models.Severity.REQUIRED,
)
issues = services.validate(asked).get_issues()
print(*(f"{one.check.identifier}: {one.message}" for one in issues), f"{len(issues)} issues", sep="\n")
