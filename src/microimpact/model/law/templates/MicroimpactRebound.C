#include "MicroimpactRebound.H"

#include "microimpact_rebound.h"
#include "wallPolyPatch.H"

template<class CloudType>
Foam::MicroimpactRebound<CloudType>::MicroimpactRebound(const dictionary& dict, CloudType& cloud)
:
    PatchInteractionModel<CloudType>(dict, cloud, typeName)
{}

template<class CloudType>
Foam::MicroimpactRebound<CloudType>::MicroimpactRebound(const MicroimpactRebound<CloudType>& other)
:
    PatchInteractionModel<CloudType>(other)
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
    if (mag(parcel.d() - MICROIMPACT_DIAMETER) > 0.01*MICROIMPACT_DIAMETER)
    {
        FatalErrorInFunction
            << "a parcel of " << parcel.d() << " m meets the rebound law of "
            << MICROIMPACT_DIAMETER << " m: export the law of its size" << exit(FatalError);
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
        -towards, tangential, 0.0, &afterNormal, &afterTangential, &afterSpin
    );
    if (outcome < 0 && towards > 0)
    {
        FatalErrorInFunction
            << "normal speed " << towards << " m/s is beyond the rebound law, "
            << MICROIMPACT_FASTEST << " m/s" << exit(FatalError);
    }
    if (outcome == 1)
    {
        parcel.U() = patchVelocity;
        parcel.active(false);
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
