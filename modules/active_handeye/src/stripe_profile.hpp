// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_STRIPE_PROFILE_HPP
#define OPENCV_ACTIVE_HANDEYE_STRIPE_PROFILE_HPP

#include "input.hpp"

namespace cv { namespace active_handeye {

//! A line through some columns of a straight piece, in ideal pixels.
struct ProfileLine
{
    Eigen::Vector2d origin, direction; //!< origin: the columns' weighted mean; direction: unit vector along the stripe
    double varianceOfOrigin;           //!< across the line, px^2
    double varianceOfSlope;

    Eigen::Vector2d normal() const { return Eigen::Vector2d(-direction.y(), direction.x()); }
    Eigen::Vector2d at(double along) const { return origin + along * direction; }

    //! Of the line's position across itself, px^2.
    double variance(double along) const { return varianceOfOrigin + along * along * varianceOfSlope; }
};

//! One point of a straight piece.
struct Column
{
    Eigen::Vector2d recorded, ideal; //!< pixel of the image, and without distortion
    double sigma;                    //!< px, across the stripe in the recorded image
};

typedef AlignedVector<Column> Columns;

//! The straight pieces of one stripe, and how much more its columns are in error than they state.
class StripeProfile
{
public:
    //! `along`: the coordinate that counts along the stripe, 0 = u, 1 = v.
    StripeProfile(const Pixels& pixels, const std::vector<double>& sigmas, const std::vector<int>& segmentIds,
                  const Camera& camera, int along, double halfWindow);

    const std::vector<Columns>& pieces() const { return pieces_; }
    double halfWindow() const { return halfWindow_; }
    int along() const { return along_; }

    //! Through columns [begin, end) of a piece; at least 3 of them.
    ProfileLine line(const Columns& piece, size_t begin, size_t end) const;

private:
    double correlationInflation() const;

    std::vector<Columns> pieces_;
    int along_;
    double halfWindow_;
    double inflation_; //!< of variances of means, for the correlation of neighbours
};

//! The profile of the arguments of locateOnStripe and findProfileCorners.
StripeProfile readStripeProfile(InputArray stripePoints, InputArray sigmas, InputArray segmentIds, const Camera& camera,
                                int orientation, double halfWindow);

}} // namespace cv::active_handeye

#endif
