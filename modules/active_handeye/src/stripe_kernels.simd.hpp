// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Included once for each set of instructions, inside an unnamed namespace. Nothing here may be shared between them: no std::, no Eigen.
// Conditions are selections of values, and accumulators are scalars of the outer loop, so that it is vectorised over the columns.

#if defined(_MSC_VER)
#define STRIPE_RESTRICT __restrict
#define STRIPE_INLINE __forceinline
#define STRIPE_INDEPENDENT __pragma(loop(ivdep))
#else
#define STRIPE_RESTRICT __restrict__
#define STRIPE_INLINE inline __attribute__((always_inline))
#if defined(__clang__)
#define STRIPE_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define STRIPE_INDEPENDENT _Pragma("GCC ivdep")
#endif
#endif

STRIPE_INLINE uchar averageOf(uchar a, uchar b)
{
    return uchar((a + b + 1) >> 1);
}
STRIPE_INLINE float averageOf(float a, float b)
{
    return 0.5f * (a + b);
}

template <typename T>
void averageRows(int n, const T* STRIPE_RESTRICT a, const T* STRIPE_RESTRICT b, T* STRIPE_RESTRICT out)
{
    for (int x = 0; x < n; ++x)
        out[x] = averageOf(a[x], b[x]);
}

template <typename T>
void scoreRows(int n, T window, const T* STRIPE_RESTRICT centre, const T* STRIPE_RESTRICT before,
               const T* STRIPE_RESTRICT after, T* STRIPE_RESTRICT highest, T* STRIPE_RESTRICT which)
{
    for (int x = 0; x < n; ++x)
    {
        const T around = averageOf(before[x], after[x]), c = centre[x];
        const T score = T(c > around ? c - around : 0), h = highest[x], w = which[x];
        which[x] = score > h ? window : w;
        highest[x] = score > h ? score : h;
    }
}

//! A condition as a value: selections by bits are vectorised where branches are not.
STRIPE_INLINE uchar maskOf(bool condition, uchar)
{
    return uchar(-int(condition));
}
STRIPE_INLINE float maskOf(bool condition, float)
{
    return condition ? 1.f : 0.f;
}
STRIPE_INLINE uchar selected(uchar mask, uchar a, uchar b)
{
    return uchar((a & mask) | (b & uchar(~mask)));
}
STRIPE_INLINE float selected(float mask, float a, float b)
{
    return mask * a + (1 - mask) * b;
}

template <typename T>
void mergeStrip(int n, T strip, T windows, T apart, T* STRIPE_RESTRICT highest, T* STRIPE_RESTRICT which,
                StripePeakRows<T> peaks)
{
    T *STRIPE_RESTRICT best = peaks.best, *STRIPE_RESTRICT bestStrip = peaks.bestStrip;
    T *STRIPE_RESTRICT bestWhich = peaks.bestWhich, *STRIPE_RESTRICT second = peaks.second;
    T *STRIPE_RESTRICT secondStrip = peaks.secondStrip, *STRIPE_RESTRICT secondWhich = peaks.secondWhich;
    STRIPE_INDEPENDENT
    for (int x = 0; x < n; ++x)
    {
        const T h = highest[x], w = which[x], b = best[x], bs = bestStrip[x], bw = bestWhich[x], s = second[x];
        const T strips = T(strip - bs), distance = T(windows + w - bw); // the latter if it is the next strip
        const T isBest = maskOf(h > b, T());
        const T lower = selected(isBest, b, h); // the one that is not the best
        const T isFar = selected(maskOf(strips > 1, T()), maskOf(true, T()), maskOf(distance > apart, T()));
        const T isSecond = selected(isFar, maskOf(lower > s, T()), T(0));
        second[x] = selected(isSecond, lower, s);
        secondStrip[x] = selected(isSecond, selected(isBest, bs, strip), secondStrip[x]);
        secondWhich[x] = selected(isSecond, selected(isBest, bw, w), secondWhich[x]);
        best[x] = selected(isBest, h, b);
        bestStrip[x] = selected(isBest, strip, bs);
        bestWhich[x] = selected(isBest, w, bw);
        highest[x] = which[x] = 0;
    }
}

//! exp(x), with a relative error of 1e-7 for |x| < 80
STRIPE_INLINE float fastExp(float x)
{
    const float shift = 12582912.f; // 1.5 * 2^23: adding it rounds to a whole number, which stands in the last bits
    const float t = x * 1.44269504f + shift, k = t - shift;
    const float r = (x - k * 0.693359375f) + k * 2.12194440e-4f;
    float p = 1.9875691500e-4f;
    p = p * r + 1.3981999507e-3f;
    p = p * r + 8.3334519073e-3f;
    p = p * r + 4.1665795894e-2f;
    p = p * r + 1.6666665459e-1f;
    p = p * r + 5.0000001201e-1f;
    p = p * r * r + r + 1;
    union
    {
        float value;
        unsigned bits;
    } whole, result;
    whole.value = t;
    result.value = p;
    result.bits += whole.bits << 23;
    return result.value;
}

STRIPE_INLINE float clamped(float value, float limit)
{
    const float upper = value < limit ? value : limit;
    return upper > -limit ? upper : -limit;
}

//! Variance of a pixel under the light, in units of that without: the background is noisy too, and multiplied by the light.
STRIPE_INLINE float darkVariance(float light, float background)
{
    const float gain = 1 + (light > 0 ? light : 0) / (background > 0 ? background : 1);
    return background > 0 ? 0.5f * (1 + gain * gain) : 1;
}

//! 1 / variance of a pixel, in units of that without light.
template <PixelModel MODEL>
STRIPE_INLINE float pixelWeight(float valid, float albedo, float light, float background, float grain)
{
    if (MODEL == PIXELS_EQUAL)
        return 1;
    const float a = MODEL == PIXELS_ANY ? albedo * light : light;
    return MODEL == PIXELS_ANY ? valid / (darkVariance(light, background) + grain * a * a) : 1 / (1 + grain * a * a);
}

//! Sums over the rows of a window, of every column.
struct FitSums
{
    float u[FIT_LANES], power[FIT_LANES], light[FIT_LANES];
    float n[FIT_LANES], gg[FIT_LANES], g1[FIT_LANES], gy[FIT_LANES], y1[FIT_LANES];
    float qq[FIT_LANES], q1[FIT_LANES], gq[FIT_LANES], qy[FIT_LANES];
};

/** Begins at the first row.

gauss[i] u^(i - middle) with u = exp(centre / sigma^2) is the profile up to a factor, which belongs to the height: `light`.
*/
void startSums(const StripeFit& fit, FitSums& sums)
{
    const int middleTap = fit.taps / 2;
    const float inverseVariance = fit.inverseVariance, middle = float(middleTap);
    for (int x = 0; x < FIT_LANES; ++x)
    {
        const float c = fit.centre[x];
        sums.u[x] = fastExp(c * inverseVariance);
        sums.power[x] = fastExp(-middle * c * inverseVariance);
        sums.light[x] = fit.height[x] * fastExp(-0.5f * c * c * inverseVariance);
        sums.n[x] = sums.gg[x] = sums.g1[x] = sums.gy[x] = sums.y1[x] = 0;
        sums.qq[x] = sums.q1[x] = sums.gq[x] = sums.qy[x] = 0;
    }
}

//! Adds some rows, so few that sums stay in registers meanwhile.
template <PixelModel MODEL, int ROWS>
void addRows(const StripeFit& fit, int first, FitSums& sums)
{
    const float* STRIPE_RESTRICT signal = fit.signal + first * FIT_LANES;
    const float* STRIPE_RESTRICT weight = fit.weight + first * FIT_LANES;
    const float* STRIPE_RESTRICT albedo = fit.albedo + first * FIT_LANES;
    const float* STRIPE_RESTRICT gauss = fit.gauss + first;
    const int fromMiddle = first - fit.taps / 2;
    const float start = float(fromMiddle);
    const float grain = fit.grain;
    const bool isAny = MODEL == PIXELS_ANY;
    FitSums& STRIPE_RESTRICT s = sums;
    for (int x = 0; x < FIT_LANES; ++x)
    {
        const float c = fit.centre[x], u = s.u[x], light = s.light[x], dark = isAny ? fit.background[x] : 0;
        float power = s.power[x], n = s.n[x], gg = s.gg[x], g1 = s.g1[x], gy = s.gy[x], y1 = s.y1[x];
        float qq = s.qq[x], q1 = s.q1[x], gq = s.gq[x], qy = s.qy[x];
        for (int i = 0; i < ROWS; ++i)
        {
            const float g = gauss[i] * power, q = g * (start + float(i) - c), y = signal[i * FIT_LANES + x];
            power *= u;
            const float a = isAny ? albedo[i * FIT_LANES + x] : 1, valid = isAny ? weight[i * FIT_LANES + x] : 1;
            const float w = pixelWeight<MODEL>(valid, a, light * g, dark, grain);
            const float wa = w * a, waa = wa * a;
            n += waa;
            gg += waa * g * g;
            g1 += waa * g;
            gy += wa * g * y;
            y1 += wa * y;
            qq += waa * q * q;
            q1 += waa * q;
            gq += waa * g * q;
            qy += wa * q * y;
        }
        s.power[x] = power;
        s.n[x] = n;
        s.gg[x] = gg;
        s.g1[x] = g1;
        s.gy[x] = gy;
        s.y1[x] = y1;
        s.qq[x] = qq;
        s.q1[x] = q1;
        s.gq[x] = gq;
        s.qy[x] = qy;
    }
}

//! Gauss-Newton with height and offset eliminated.
void stepCentres(const FitSums& sums, StripeFit& fit)
{
    const int middleTap = fit.taps / 2;
    const float inverseVariance = fit.inverseVariance, largestStep = fit.largestStep, middle = float(middleTap);
    const float noiseScale = 4e2f / (fit.pixelNoise * fit.pixelNoise); // a twentieth of a standard deviation
    StripeFit& STRIPE_RESTRICT f = fit;
    for (int x = 0; x < FIT_LANES; ++x)
    {
        const float c = f.centre[x], n = sums.n[x], gg = sums.gg[x], g1 = sums.g1[x], gy = sums.gy[x], y1 = sums.y1[x];
        const float qq = sums.qq[x], q1 = sums.q1[x], gq = sums.gq[x], qy = sums.qy[x];
        const float determinant = gg * n - g1 * g1;
        const float h = (n * gy - g1 * y1) / determinant, o = (gg * y1 - g1 * gy) / determinant;
        const float slope = h * inverseVariance;
        const float known = qq - (n * gq * gq - 2 * g1 * gq * q1 + gg * q1 * q1) / determinant;
        const float step = clamped((qy - h * gq - o * q1) / (slope * known), largestStep), square = step * step;
        const float information = slope * slope * known;
        const float rest = square * information * noiseScale, roundingRest = square * 1e10f;
        const bool isPeak = (determinant > 1e-6f * gg * n) & (h > 0) & (known > 1e-6f * qq) & (c < middle) &
                            (c > -middle) & (f.failed[x] == 0);
        f.failed[x] = isPeak ? 0.f : 1.f;
        f.height[x] = h * fastExp(0.5f * c * c * inverseVariance);
        f.offset[x] = o;
        f.information[x] = information;
        f.centre[x] = isPeak ? c + step : c;
        f.move[x] = isPeak ? (rest < roundingRest ? rest : roundingRest) : 0.f;
    }
}

template <PixelModel MODEL>
void fitColumns(StripeFit& fit)
{
    FitSums sums;
    startSums(fit, sums);
    const int portion = 4;
    int row = 0;
    for (; row + portion <= fit.taps; row += portion)
        addRows<MODEL, portion>(fit, row, sums);
    for (; row < fit.taps; ++row)
        addRows<MODEL, 1>(fit, row, sums);
    stepCentres(sums, fit);
}

template <PixelModel MODEL>
void assessColumns(StripeFit& fit)
{
    FitSums sums;
    startSums(fit, sums);
    const bool isAny = MODEL == PIXELS_ANY;
    StripeFit& STRIPE_RESTRICT f = fit;
    for (int x = 0; x < FIT_LANES; ++x)
        f.squares[x] = f.pixels[x] = 0;
    for (int i = 0; i < f.taps; ++i)
        for (int x = 0; x < FIT_LANES; ++x)
        {
            const float g = f.gauss[i] * sums.power[x], a = isAny ? f.albedo[i * FIT_LANES + x] : 1;
            const float v = isAny ? f.weight[i * FIT_LANES + x] : 1, light = sums.light[x] * g;
            const float w = pixelWeight<MODEL>(v, a, light, isAny ? f.background[x] : 0, f.grain);
            const float residual = f.signal[i * FIT_LANES + x] - a * (light + f.offset[x]);
            sums.power[x] *= sums.u[x];
            f.squares[x] += w * residual * residual;
            f.pixels[x] += v;
        }
}

template <typename T>
StripeRowKernels<T> rowKernels()
{
    const StripeRowKernels<T> kernels = {averageRows<T>, scoreRows<T>, mergeStrip<T>};
    return kernels;
}

StripeKernels allKernels()
{
    const StripeKernels kernels = {
        rowKernels<uchar>(),
        rowKernels<float>(),
        {fitColumns<PIXELS_EQUAL>, fitColumns<PIXELS_GRAINY>, fitColumns<PIXELS_ANY>},
        {assessColumns<PIXELS_EQUAL>, assessColumns<PIXELS_GRAINY>, assessColumns<PIXELS_ANY>}};
    return kernels;
}

#undef STRIPE_RESTRICT
#undef STRIPE_INLINE
#undef STRIPE_INDEPENDENT
