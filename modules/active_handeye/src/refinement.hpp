// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_ACTIVE_HANDEYE_REFINEMENT_HPP
#define OPENCV_ACTIVE_HANDEYE_REFINEMENT_HPP

#include "noise_levels.hpp"
#include "observability.hpp"
#include "refine_input.hpp"
#include "turn_directions.hpp"

#include <memory>

namespace cv { namespace active_handeye {

//! Evidence for one lens model: whether the coefficients that it lacks are there.
struct LensTest
{
    double statistic = 0, pValue = 1;
    int lacking = 0;

    //! Akaike's, up to a constant: -2 log likelihood + 2 x coefficients.
    double informationCriterion() const { return statistic - 2 * lacking; }
};

enum
{
    LENS_MODELS = LENS_K3 + 1
};

//! Derivative (20 x CALIBRATION_COLUMNS) of the parameters of RefineSummary by a step of the calibration.
Eigen::MatrixXd parametersByStep(const HandEyeCalibration& calibration);

//! How many of k1, k2, p1, p2, k3 a lens model estimates.
int lensCoefficients(int lensModel);

//! The steps of refineHandEye(), in the order of their use.
class HandEyeRefinement
{
public:
    //! doubted: views whose reported pose is not believed from the beginning.
    HandEyeRefinement(const RefineMeasurements& measurements, const RefineParams& params,
                      const HandEyeCalibration& start, const std::vector<int>& doubted);

    //! Scene points, wrong matches, first noise levels.
    void findScene();

    //! Maximum likelihood from the points, with the views that are not believed and the lens model.
    void fitPoints();

    //! How far, in pixels, image and robot noise together move an image point.
    double misfit() const;

    //! Takes the stripes in, from a first light plane on.
    void fitStripes(const LightPlane& start);

    //! Throws StsNoConv when something is not determined.
    void requireAnswer();

    void summarize(RefineSummary& summary) const;

    //! Instead of all steps above: takes the start, these points (one for each column of imagePoints) and these stripes
    //! for true. The noise levels are those given, and lensModel is not LENS_AUTO.
    void assume(const AlignedVector<Eigen::Vector3d>& points, const AlignedVector<Eigen::Vector4d>& surfaces,
                const StripeSegments& segments);

    //! Covariance and weak directions at what is assumed.
    void predict(RefineSummary& summary);

    const RefineProblem& problem() const { return problem_; }

    const HandEyeCalibration& calibration() const { return problem_.state.calibration; }
    double rms() const;

private:
    void requireTracks() const;
    void setUnknowns(bool isAspectFree = false);
    void fit(double tolerance);
    bool leaveOut(double limit);
    void leaveOutUnseenViews(const std::vector<double>& errors, double limit);
    void fitWithoutWrongMatches();
    std::vector<double> usedErrors() const; //!< px
    void firstNoiseLevels(double scale);
    bool isDoubted(int view) const;
    double devianceOfShift(int view) const;
    double robotRedundancy() const;
    double beliefInNoise(double devianceOfNoise, double redundancy, double devianceOfShift) const;
    double beliefInView(int view) const;
    bool areRobotLevelsKnown() const;
    bool rehabilitate(int view, double level);
    bool rehabilitateView(double level);
    bool doubtViews();
    double viewStatistic(int view, const Eigen::Matrix<double, 6, 6>& predicted) const;
    Eigen::Matrix<double, 6, 6> priorCovariance() const;
    Eigen::Matrix<double, 6, 6> poseCovariance(int view) const;
    void testLens();
    void testAspect();
    int lensOfTests() const;
    bool chooseLens();
    void addSegments();
    void placeSurfaces();
    bool leaveOutSegments();
    void compactSurfaces();
    double workingDistance() const;
    double robotNoiseInImage() const; //!< px
    bool isLevelGiven(int component) const;
    bool observesTranslation() const;

    void requireConvergence(double limit) const;
    void requireRedundancy() const;
    std::vector<WeakDirection> weakDirectionsOf(const VarianceComponents& components) const;
    double deviationsHeldByLens();
    std::vector<WeakDirection> weakDirectionsOfReportedMotion() const;
    void summarizeParameters(RefineSummary& summary) const;
    void summarizeNoise(RefineSummary& summary) const;
    void summarizeResiduals(RefineSummary& summary) const;
    void summarizeStripes(RefineSummary& summary) const;
    void summarizeStripeGroups(RefineSummary& summary) const;
    Eigen::Vector2d lightPlaneDeviationsWithout(const std::vector<int>& views) const;
    void summarizeVerdict(RefineSummary& summary) const;

    const RefineMeasurements& measurements_;
    const RefineParams& params_;
    const TurnDirections turns_;
    const HandEyeCalibration start_;
    SceneTracks tracks_;
    StripeSegments segments_;
    RefineProblem problem_;
    std::unique_ptr<VarianceComponents> components_;
    int lensModel_;
    LensTest lensTests_[LENS_MODELS];
    double aspectPValue_ = 1;
    bool useStripes_ = false, converged_ = false;
    int iterations_ = 0;
    std::vector<std::string> culprits_, weakDirections_;
    std::vector<int> doubtedViews_;
    std::vector<int> leftOutSegments_;
};

}} // namespace cv::active_handeye

#endif
