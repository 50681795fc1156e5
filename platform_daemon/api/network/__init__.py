"""What stands between the network and the routes; all of it would move with the routes into another process.

limits: How much anybody may ask for at once.
refusals: The kinds of problems that are answered here.
access: The one table of who may do what: operation -> role, and how much it takes.
origins: By which names the server is called, and from which pages of a browser.
callers: Who asks: the holder of a token, or anybody on a computer where none is demanded.
rate: How often a client may ask.
lanes: How many requests that compute run at once.
policy: What a server demands of those who ask.
auditing: Writes what a request has changed into the audit log.
body: Reading a body no longer and no slower than is allowed.
query: A key of the query that nobody knows is refused.
routes: The class of all routes: token, role, origin, content type and body are looked at before anything else.
front: The outermost layer: names of the host, rate.
entrance: How many may stand before TLS.
connections: How many connections there are, and how long one may say nothing.
room: Which connections there are, whose, and which of them may have to make room.
strict_http: What could mean two things to two readers is refused.
certificates: Is a certificate good for the names of this server?
listening: On which address the server may listen, and by which rules.
served: An application on its socket, in a thread of its own.
"""
