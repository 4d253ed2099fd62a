/* Registers the patch interaction for the cloud of icoUncoupledKinematicParcelFoam and its kin;
 * name the cloud of your solver here. */
#include "basicKinematicCollidingCloud.H"
#include "MicroimpactRebound.H"

makePatchInteractionModelType(MicroimpactRebound, basicKinematicCollidingCloud)
