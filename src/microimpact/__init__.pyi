from .core.declared import materials as materials
from .core.materials import Material as Material
from .measured.rebounds import read_rebounds as read_rebounds
from .model import JKR as JKR
from .model import Contact as Contact
from .model import Hysteresis as Hysteresis
from .model import Impact as Impact
from .model import Law as Law
from .model import MaugisBarquins as MaugisBarquins
from .model import SpatialImpact as SpatialImpact
from .model import ThorntonNing as ThorntonNing
from .model import Trajectory as Trajectory
from .model import bootstrap_v_c as bootstrap_v_c
from .model import calibrate_laws as calibrate_laws
from .model import capture_velocity as capture_velocity
from .model import compare_models as compare_models
from .model import export as export
from .model import fit_restitution as fit_restitution
from .model import planar as planar
from .model import restitution as restitution
from .model import rigid_body_rebound as rigid_body_rebound
from .model import simulate as simulate
from .model import spatial as spatial
from .model import tabulate as tabulate
from .model import trajectory as trajectory
from .model.declared import contacts as contacts

__version__: str
