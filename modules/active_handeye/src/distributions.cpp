// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "distributions.hpp"

namespace cv { namespace active_handeye {

namespace {

const double precision = 1e-15, tiny = 1e-300;
const int maxTerms = 10000;

//! Regularised upper incomplete gamma function Q(a, x): series below the mean, Lentz's continued fraction above.
double upperGamma(double a, double x)
{
    const double factor = std::exp(a * std::log(x) - x - std::lgamma(a));
    if (x < a + 1)
    {
        double term = 1 / a, sum = term;
        for (int n = 1; n < maxTerms && term > precision * sum; ++n)
            sum += term *= x / (a + n);
        return 1 - factor * sum;
    }
    double b = x + 1 - a, c = 1 / tiny, d = 1 / b, fraction = d;
    for (int n = 1; n < maxTerms; ++n)
    {
        const double an = n * (a - n);
        b += 2;
        d = 1 / (b + an * d);
        c = b + an / c;
        fraction *= c * d;
        if (std::abs(c * d - 1) < precision)
            break;
    }
    return factor * fraction;
}

//! Continued fraction of the incomplete beta function (Lentz).
double betaFraction(double a, double b, double x)
{
    double c = 1, d = 1 / std::max(tiny, 1 - (a + b) * x / (a + 1)), fraction = d;
    for (int m = 1; m < maxTerms; ++m)
    {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        for (double term : {even, odd})
        {
            d = 1 / (1 + term * d);
            c = 1 + term / c;
            fraction *= c * d;
        }
        if (std::abs(c * d - 1) < precision)
            break;
    }
    return fraction;
}

//! Regularised incomplete beta function I_x(a, b).
double incompleteBeta(double a, double b, double x)
{
    if (x <= 0 || x >= 1)
        return x <= 0 ? 0 : 1;
    const double factor =
        std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
    return x < (a + 1) / (a + b + 2) ? factor * betaFraction(a, b, x) / a : 1 - factor * betaFraction(b, a, 1 - x) / b;
}

} // namespace

double chiSquareTail(double x, double dof)
{
    return x <= 0 ? 1 : upperGamma(dof / 2, x / 2);
}

double fTail(double x, double dof1, double dof2)
{
    const double normalDof = 1e6;
    if (dof2 > normalDof)
        return chiSquareTail(x * dof1, dof1);
    return x <= 0 ? 1 : incompleteBeta(dof2 / 2, dof1 / 2, dof2 / (dof2 + dof1 * x));
}

double studentQuantile(double p, double dof)
{
    double low = 0, high = 1;
    while (fTail(high * high, 1, dof) > p) // t^2 is F(1, dof)
        high *= 2;
    for (int i = 0; i < 100 && high - low > 1e-14 * high; ++i)
    {
        const double middle = 0.5 * (low + high);
        (fTail(middle * middle, 1, dof) > p ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

}} // namespace cv::active_handeye
