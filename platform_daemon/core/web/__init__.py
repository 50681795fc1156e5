"""The web application: problem details, roles and access, event stream, stop port."""
