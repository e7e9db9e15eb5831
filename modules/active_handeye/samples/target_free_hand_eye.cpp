// Calibrates a camera in the hand of a robot from what it saw of an ordinary scene: camera matrix, lens and hand-eye transform with
// 95 % intervals. Reads a file of cv::FileStorage with R_gripper2base, t_gripper2base and imagePoints (a list of matrices each); without
// one it makes a scene of its own and says how far the result is from the truth.
#include <opencv2/core.hpp>
#include <opencv2/active_handeye.hpp>

#include <cmath>
#include <cstdio>
#include <iostream>

using namespace cv;
using std::vector;

struct Recording
{
    vector<Mat> R_gripper2base, t_gripper2base; // what the robot reports
    vector<Mat> imagePoints; // N x 2 pixels a view; row j is the same point in every view; NaN = not seen
};

static vector<Mat> readList(const FileNode& node)
{
    vector<Mat> list;
    for (FileNodeIterator item = node.begin(); item != node.end(); ++item)
    {
        Mat matrix;
        *item >> matrix;
        list.push_back(matrix);
    }
    return list;
}

static Recording readRecording(const String& file)
{
    const FileStorage storage(file, FileStorage::READ);
    if (!storage.isOpened())
        CV_Error(Error::StsBadArg, "cannot read " + file);
    Recording r;
    r.R_gripper2base = readList(storage["R_gripper2base"]);
    r.t_gripper2base = readList(storage["t_gripper2base"]);
    r.imagePoints = readList(storage["imagePoints"]);
    return r;
}

static Matx33d rotation(double x, double y, double z) // by these angles about the three axes, rad
{
    const Matx33d aboutX(1, 0, 0, 0, cos(x), -sin(x), 0, sin(x), cos(x)),
        aboutY(cos(y), 0, sin(y), 0, 1, 0, -sin(y), 0, cos(y));
    const Matx33d aboutZ(cos(z), -sin(z), 0, sin(z), cos(z), 0, 0, 0, 1);
    return aboutZ * aboutY * aboutX;
}

static const Matx33d trueCamera(1400, 0, 320, 0, 1400, 240, 0, 0, 1), trueRotation = rotation(0.05, -0.03, 1.5);
static const Vec3d trueTranslation(-5, 103, 104); // mm

// Seven orientations, in three of them five stops, over eighty points; 0.1 px of noise.
static Recording simulate()
{
    RNG rng(1);
    vector<Vec3d> scene;
    for (int j = 0; j < 80; ++j)
        scene.push_back(Vec3d(300 + rng.uniform(-90., 90.), rng.uniform(-70., 70.), rng.uniform(-60., 60.)));
    const Vec3d turns[] = {Vec3d(0, 0, 0),          Vec3d(0.35, 0, 0),     Vec3d(-0.1, 0.3, 1.2), Vec3d(0, 0.3, 0.4),
                           Vec3d(-0.2, -0.2, -0.8), Vec3d(0.2, -0.3, 2.5), Vec3d(-0.3, 0.1, -1.6)};
    const Vec3d stops[] = {Vec3d(0, 0, 0), Vec3d(50, 5, 20), Vec3d(-10, 45, -25), Vec3d(5, -20, 50),
                           Vec3d(-45, -30, -15)};
    Recording r;
    for (int k = 0; k < 7; ++k)
        for (int stop = 0; stop < (k < 3 ? 5 : 1); ++stop)
        {
            const Matx33d R = rotation(turns[k][0], turns[k][1], turns[k][2]) * rotation(3.1, 0.1, 0.05);
            const Matx33d cam2base = R * trueRotation;
            const Vec3d centre = Vec3d(300, 0, 0) + cam2base * (stops[stop] - Vec3d(0, 0, 550));
            Mat pixels(int(scene.size()), 2, CV_64F);
            for (int j = 0; j < pixels.rows; ++j)
            {
                const Vec3d x = trueCamera * (cam2base.t() * (scene[j] - centre));
                pixels.at<double>(j, 0) = x[0] / x[2] + rng.gaussian(0.1);
                pixels.at<double>(j, 1) = x[1] / x[2] + rng.gaussian(0.1);
            }
            r.R_gripper2base.push_back(Mat(R));
            r.t_gripper2base.push_back(Mat(Vec3d(centre - R * trueTranslation)));
            r.imagePoints.push_back(pixels);
        }
    return r;
}

int main(int argc, char** argv)
{
    const CommandLineParser parser(argc, argv,
                                   "{help h||}{@recording||file of cv::FileStorage; none = a simulated scene}");
    if (parser.has("help"))
    {
        parser.printMessage();
        return 0;
    }
    try
    {
        const String file = parser.get<String>("@recording");
        const Recording r = file.empty() ? simulate() : readRecording(file);
        Mat K, D, R, t, light; // empty: no start is needed
        active_handeye::RefineSummary summary;
        const double rms = active_handeye::refineHandEye(r.R_gripper2base, r.t_gripper2base, r.imagePoints, K, D, R, t,
                                                         light, summary);
        std::cout << summary.message << "\nreprojection error " << rms << " px\n"
                  << "cameraMatrix\n"
                  << K << "\nR_cam2gripper\n"
                  << R << "\nt_cam2gripper " << t.t() << "\n";
        for (size_t i = 0; i < summary.parameterNames.size(); ++i)
            if (summary.standardDeviations.at<double>(int(i)) > 0)
                std::printf("%5s  %12.5f to %12.5f\n", summary.parameterNames[i].c_str(),
                            summary.intervals95.at<double>(int(i), 0), summary.intervals95.at<double>(int(i), 1));
        if (file.empty())
            std::cout << "t_cam2gripper is off by " << norm(t, Mat(trueTranslation)) << " mm\n";
        return summary.usable ? 0 : 1;
    }
    catch (const cv::Exception& e) // says which argument, or which motion is missing
    {
        std::cerr << e.err << std::endl;
        return 2;
    }
}
