from .checkup import examine as examine
from .notify import service_manager as service_manager
from .owner import guard_for as guard_for
from .owner import needs_guard as needs_guard
from .ownership import owner_of as owner_of
from .places import place_of as place_of
from .rescue import outputs_off as outputs_off
from .rescue import reset_fault as reset_fault
