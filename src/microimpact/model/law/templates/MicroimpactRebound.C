#include "MicroimpactRebound.H"

#include "microimpact_rebound.h"
#include "wallPolyPatch.H"

template<class CloudType>
Foam::MicroimpactRebound<CloudType>::MicroimpactRebound(const dictionary& dict, CloudType& cloud)
:
    PatchInteractionModel<CloudType>(dict, cloud, typeName),
    mass_(cloud.mesh().boundaryMesh().size(), scalar(0)),
    number_(mass_)
{}

template<class CloudType>
Foam::MicroimpactRebound<CloudType>::MicroimpactRebound(const MicroimpactRebound<CloudType>& other)
:
    PatchInteractionModel<CloudType>(other),
    mass_(other.mass_),
    number_(other.number_)
{}

template<class CloudType>
bool Foam::MicroimpactRebound<CloudType>::correct
(
    typename CloudType::parcelType& parcel,
    const polyPatch& patch,
    bool& keepParticle
)
{
    keepParticle = true;
    if (!isA<wallPolyPatch>(patch))
    {
        return false;
    }

    // The normal points out of the domain; velocities are relative to the patch
    vector normal, patchVelocity;
    this->owner().patchData(parcel, patch, normal, patchVelocity);
    const vector relative = parcel.U() - patchVelocity;
    const scalar towards = relative & normal;
    const vector along = relative - towards*normal;
    const scalar tangential = mag(along);

    double afterNormal, afterTangential, afterSpin;
    const int outcome = microimpact_rebound
    (
        parcel.d(), -towards, tangential, 0.0, &afterNormal, &afterTangential, &afterSpin
    );
    if (outcome == -2)
    {
        FatalErrorInFunction
            << "a parcel of " << parcel.d() << " m meets the rebound law of " << MICROIMPACT_SMALLEST
            << " to " << MICROIMPACT_LARGEST << " m: export it for all sizes" << exit(FatalError);
    }
    if (outcome == -1 && towards > 0)
    {
        FatalErrorInFunction
            << "normal speed " << towards << " m/s is beyond the rebound law, "
            << MICROIMPACT_FASTEST << " m/s" << exit(FatalError);
    }
    if (outcome == 1)
    {
        parcel.U() = patchVelocity;
        parcel.active(false);
        mass_[patch.index()] += parcel.nParticle()*parcel.mass();
        number_[patch.index()] += parcel.nParticle();
    }
    else if (outcome == 0)
    {
        parcel.U() = patchVelocity - afterNormal*normal;
        if (tangential > 0)
        {
            parcel.U() += afterTangential/tangential*along;
        }
    }
    return true;
}

template<class CloudType>
void Foam::MicroimpactRebound<CloudType>::report()
{
    const polyBoundaryMesh& patches = this->owner().mesh().boundaryMesh();
    forAll(patches, patchi)
    {
        const scalar number = returnReduce(number_[patchi], sumOp<scalar>());
        const scalar mass = returnReduce(mass_[patchi], sumOp<scalar>());
        if (isA<wallPolyPatch>(patches[patchi]))
        {
            Info<< "    Captured in this run by patch " << patches[patchi].name() << ": "
                << number << " particles, " << mass << " kg" << nl;
        }
    }
}
