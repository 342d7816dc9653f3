
/* v / 2^places, halves away from zero. */
static inline int64_t @p@_rounded(int64_t v, int32_t places)
{
    const int64_t half = ((int64_t)1 << places) / 2;
    return v < 0 ? -((half - v) >> places) : (v + half) >> places;
}

/* Pictures saturate at 8. */
static inline int32_t @p@_saturated(int64_t v)
{
    return v > @P@_MOST ? @P@_MOST : v < -@P@_MOST ? -@P@_MOST : (int32_t)v;
}

/* Bits of a number that is not negative. */
static inline int32_t @p@_length(int64_t v)
{
    int32_t n = 0;
    for (; v != 0; v >>= 1)
        n++;
    return n;
}

/* c[0] + x (c[1] + x c[2]), none of them negative; what the last two have places. */
static inline int64_t @p@_polynomial(const int64_t c[5], int64_t x)
{
    return c[0] + ((x * (c[1] + ((x * c[2]) >> c[4]))) >> c[3]);
}

/* A pixel of the first stage: its sums as numbers of @P@_PLACES binary places. */
static inline void @p@_first_pixel(const @p@_raw *raw, int32_t row, int32_t col, int32_t out[3])
{
    int32_t sums[3], o;
    const int32_t places = @P@_UNIT_PLACES + @p@_pixel(raw, row, col, sums);
    for (o = 0; o < 3; o++)
        out[o] = @p@_saturated(@p@_rounded((int64_t)sums[o] * @P@_UNIT, places));
}

/* A pixel of a smooth picture: the mean over 3 x 3 pixels `step` apart, with binomial weights times (most - d)^2, where d is
   the squared difference of the colours. Neighbours whose difference is above `most` do not count. */
static inline void @p@_smooth(const @p@_picture *from, int32_t row, int32_t col, int32_t step,
                             const int64_t squares[5], int32_t out[3])
{
    /* Down, right, times. */
    static const int8_t around[8][3] = { { -1, 0, 2 }, { 0, -1, 2 }, { 0, 1, 2 }, { 1, 0, 2 },
                                         { -1, -1, 1 }, { -1, 1, 1 }, { 1, -1, 1 }, { 1, 1, 1 } };
    int32_t own[3], shift, i, plane;
    int64_t sums[3] = { 0, 0, 0 }, most, total;
    for (plane = 0; plane < 3; plane++)
        own[plane] = @p@_at(from, plane, row, col);
    most = @p@_polynomial(squares, own[1] > 0 ? own[1] : 0);
    most = most > 1 ? most : 1;
    /* Weights have 14 bits before they are squared. */
    shift = @p@_length(most) - 14;
    shift = shift > 0 ? shift : 0;
    total = 4 * (most >> shift) * (most >> shift);
    for (i = 0; i < 8; i++) {
        int64_t d[3], left, weight;
        for (plane = 0; plane < 3; plane++)
            d[plane] = @p@_at(from, plane, row + around[i][0] * step, col + around[i][1] * step) - own[plane];
        left = most - (d[0] * d[0] + 2 * d[1] * d[1] + d[2] * d[2]);
        left = left > 0 ? left >> shift : 0;
        weight = around[i][2] * left * left;
        total += weight;
        for (plane = 0; plane < 3; plane++)
            sums[plane] += weight * d[plane];
    }
    for (plane = 0; plane < 3; plane++) {
        const int64_t mean = ((sums[plane] < 0 ? -sums[plane] : sums[plane]) + total / 2) / total;
        out[plane] = @p@_saturated(own[plane] + (sums[plane] < 0 ? -mean : mean));
    }
}

/* The class of a pixel: level and structure, by Y of the finest smooth picture. */
static inline uint32_t @p@_refined_class(const @p@_picture *p, int32_t row, int32_t col)
{
    static const int8_t tent[5] = { 1, 2, 3, 2, 1 }, binomial[3] = { 1, 2, 1 };
    int64_t tensor[3] = { 0, 0, 0 }, sum = 0, noise, trace, difference, twice, divisor;
    int32_t level = 0, strength = 0, kind = 0, i, r, c;
    for (r = -2; r <= 2; r++)
        for (c = -2; c <= 2; c++) {
            const int32_t times = tent[r + 2] * tent[c + 2];
            const int64_t across = @p@_at(p, 1, row + r, col + c + 1) - @p@_at(p, 1, row + r, col + c - 1);
            const int64_t down = @p@_at(p, 1, row + r + 1, col + c) - @p@_at(p, 1, row + r - 1, col + c);
            tensor[0] += times * across * across;
            tensor[1] += times * down * down;
            tensor[2] += times * across * down;
        }
    for (r = -1; r <= 1; r++)
        for (c = -1; c <= 1; c++)
            sum += binomial[r + 1] * binomial[c + 1] * @p@_at(p, 1, row + r, col + c);
#if @P@_REFINED_LEVELS > 1
    for (i = 0; i < @P@_REFINED_LEVELS - 1; i++)
        level += @p@_refined_cuts[i] <= sum;
#endif
    noise = @p@_polynomial(@p@_noise, sum > 0 ? sum : 0);
    trace = tensor[0] + tensor[1];
    difference = tensor[0] - tensor[1];
    twice = 2 * tensor[2];
    for (i = 0; i < @P@_STRENGTHS; i++)
        strength += (trace >> @P@_TENSOR_SHIFT) > ((@p@_strengths[i][0] * noise) >> @p@_strengths[i][1]);
    if (strength == 0)
        return (uint32_t)(level * @P@_STRUCTURES);
    /* What follows squares 30 bits. */
    i = @p@_length(trace) - 30;
    divisor = (int64_t)1 << (i > 0 ? i : 0);
    trace /= divisor;
    difference /= divisor;
    twice /= divisor;
    if (4 * (difference * difference + twice * twice) > trace * trace) {
        const int64_t along = difference < 0 ? -difference : difference, across = twice < 0 ? -twice : twice;
#if @P@_ORIENTATIONS == 8
        /* The tangent of 22.5 degrees is 13573 / 2^15. */
        const int32_t from_axis = (across * 32768 > 13573 * along) + (13573 * across >= along * 32768);
        const int32_t turned = difference >= 0 ? from_axis : 4 - from_axis;
        kind = 1 + (twice > 0 ? turned : (8 - turned) % 8);
#else
        kind = 1 + (along >= across ? (difference >= 0 ? 0 : 2) : (twice > 0 ? 1 : 3));
#endif
    }
    return (uint32_t)(level * @P@_STRUCTURES + 1 + (strength - 1) * (1 + @P@_ORIENTATIONS) + kind);
}

/* The square root, rounded to the nearest integer. */
static inline int32_t @p@_root(uint64_t v)
{
    uint64_t root = 0, bit = UINT64_C(1) << 26;
    v *= 4;
    for (; bit != 0; bit >>= 1)
        if ((root + bit) * (root + bit) <= v)
            root += bit;
    return (int32_t)((root + 1) / 2);
}

/* Square roots of products of red, green and blue of ITU-R BT.2020. Negative channels count as 0. */
static inline void @p@_roots(const @p@_picture *p, int32_t row, int32_t col, int32_t out[3])
{
    uint64_t rgb[3];
    int32_t i, plane;
    for (i = 0; i < 3; i++) {
        int64_t sum = 0;
        for (plane = 0; plane < 3; plane++)
            sum += @p@_rgb_from_xyz[i][plane] * @p@_at(p, plane, row, col);
        sum = @p@_rounded(sum, 30);
        rgb[i] = sum > 0 ? (uint64_t)sum : 0;
    }
    for (i = 0; i < 3; i++)
        out[i] = @p@_root(rgb[i] * rgb[(i + 1) % 3]);
}

/* The outputs of a pixel of the second stage, from all pictures. */
static inline void @p@_refined_pixel(const @p@_picture pictures[@P@_PICTURES], int32_t row, int32_t col, int32_t out[3])
{
    static const int8_t sides[3][2] = { { 1, 2 }, { 0, 1 }, { 2, 1 } }; /* plane, half the side of the patch */
    const uint32_t class_index = @p@_refined_class(&pictures[1], row, col);
    int32_t inputs[@P@_INPUTS], at = 0, scale, plane, o, r, c, i;
    for (i = 0; i < 3; i++)
        for (r = -sides[i][1]; r <= sides[i][1]; r++)
            for (c = -sides[i][1]; c <= sides[i][1]; c++)
                inputs[at++] = @p@_at(&pictures[0], sides[i][0], row + r, col + c);
    for (scale = 0; scale < 5; scale++)
        for (plane = 0; plane < 3; plane++)
            inputs[at++] = scale < 3 ? @p@_at(&pictures[1 + scale], plane, row, col)
                                     : @p@_at(&pictures[2 + scale], plane, row / 2, col / 2);
    @p@_roots(&pictures[3], row, col, inputs + at);
    for (o = 0; o < 3; o++) {
        const int16_t *k = @p@_refined_kernels[class_index][o];
        int64_t sum = @p@_refined_offsets[class_index][o];
        for (i = 0; i < @P@_INPUTS; i++)
            sum += (int64_t)k[i] * inputs[i];
        out[o] = @p@_saturated(@p@_rounded(sum, @p@_refined_shifts[class_index]));
    }
}

/* The Y that the sample of a pixel gives, from Y and responses of the samples around it that see the same cell of the tile:
   at least half of `light` and at most twice as much. It is `light` where the sample is clipped or the tile has more than
   four rows and columns. */
static inline int64_t @p@_given(const @p@_raw *raw, const @p@_picture *p, int32_t row, int32_t col, int64_t light)
{
    const int32_t down = 4 / @P@_TILE_ROWS * @P@_TILE_ROWS, right = 4 / @P@_TILE_COLS * @P@_TILE_COLS;
    int64_t own = -1, lights = 0, responses = 0, given;
    int32_t r, c;
    if (@P@_TILE_ROWS > 4 && @P@_TILE_COLS > 4)
        return light;
    for (r = row - down; r <= row + down; r += @P@_TILE_ROWS)
        for (c = col - right; c <= col + right; c += @P@_TILE_COLS) {
            int64_t response, y, total;
            int32_t sample;
            if (r < 0 || r >= raw->rows || c < 0 || c >= raw->cols)
                continue;
            sample = @p@_sample(raw, r, c);
            if ((uint32_t)sample >= @P@_CLIP)
                continue;
            response = (int64_t)sample * 256 - @P@_RESPONSE_BLACK;
            response = response > 0 ? (response * @P@_RESPONSE) >> 24 : 0;
            if (r == row && c == col)
                own = response;
            y = @p@_light(p, r, c);
            total = y + response + @P@_DARK;
            lights += (y << 14) / total;
            responses += (response << 14) / total;
        }
    if (own < 0 || responses == 0)
        return light;
    given = own * lights / responses;
    given = given < light / 2 ? light / 2 : given;
    return given > 2 * light ? 2 * light : given;
}

/* A pixel of the refined picture. Beside light that is many times as bright it has the mean colour of the light around it,
   in which light near saturation counts less and X and Z are at most 3 and 16 times Y. Its Y goes halfway to the one that its
   own sample gives, and is at least half of the mean Y of its neighbours and a quarter of the mean Y around it. */
static inline void @p@_corrected(const @p@_raw *raw, const @p@_picture *p, int32_t row, int32_t col, int32_t out[3])
{
    /* By distance: right shifts of Y, and left shifts of Y and noise, in the contrast. */
    static const int8_t falls[5] = { 0, 0, 0, 1, 2 };
    /* Weights of the mean Y, by distance; those of a line sum to 256. */
    static const int8_t weights[5] = { 70, 56, 28, 8, 1 };
    int64_t brightest = 0, darkest = INT64_MAX, sums[4] = { 0, 0, 0, 0 }, around = 0, nearby = 0, share, least, light, total, goal[3];
    int32_t r, c, plane;
    for (r = -4; r <= 4; r++)
        for (c = -4; c <= 4; c++) {
            const int32_t down = r < 0 ? -r : r, right = c < 0 ? -c : c;
            const int32_t fall = falls[down] + falls[right];
            const int64_t y = @p@_light(p, row + r, col + c), lit = y >> fall, dark = (y + @P@_DARK) << fall;
            brightest = lit > brightest ? lit : brightest;
            darkest = dark < darkest ? dark : darkest;
        }
    for (plane = 0; plane < 3; plane++)
        out[plane] = @p@_at(p, plane, row, col);
    brightest -= 16 * darkest;
    if (brightest <= 0)
        return;
    share = (brightest << 10) / (16 * darkest);
    share = share < 1 << 10 ? share : 1 << 10;
    for (r = -4; r <= 4; r++)
        for (c = -4; c <= 4; c++) {
            const int32_t down = r < 0 ? -r : r, right = c < 0 ? -c : c;
            int64_t headroom = (int64_t)1 << 20;
            for (plane = 0; plane < 3; plane++) {
                const int64_t rest = ((int64_t)1 << 20) - @p@_at(p, plane, row + r, col + c);
                headroom = rest < headroom ? rest : headroom;
            }
            headroom = headroom > (int64_t)1 << 18 ? headroom : (int64_t)1 << 18;
            headroom = (headroom * headroom) >> 20;
            headroom = (headroom * headroom) >> 20;
            for (plane = 0; plane < 3; plane++)
                sums[plane] += headroom * @p@_at(p, plane, row + r, col + c);
            sums[3] += headroom;
            around += (int64_t)(weights[down] * weights[right]) * @p@_light(p, row + r, col + c);
            if (down <= 1 && right <= 1)
                nearby += (int64_t)((2 - down) * (2 - right)) * @p@_light(p, row + r, col + c);
        }
    nearby = @p@_rounded(nearby, 4) / 2;
    for (plane = 0; plane < 3; plane++)
        sums[plane] = @p@_rounded(sums[plane], 8);
    least = around / (1 << 18);
    least = nearby > least ? nearby : least;
    light = out[1] > least ? out[1] : least;
    light = (light + @p@_given(raw, p, row, col, light)) / 2;
    light = light > least ? light : least;
    total = (@P@_DARK * sums[3]) >> 8;
    total = sums[1] > total ? sums[1] : total;
    total = sums[0] / 3 > total ? sums[0] / 3 : total;
    total = sums[2] / 16 > total ? sums[2] / 16 : total;
    for (plane = 0; plane < 3; plane++)
        goal[plane] = @p@_saturated((sums[plane] > 0 ? sums[plane] : 0) * light / total);
    goal[1] = @p@_saturated(light);
    for (plane = 0; plane < 3; plane++)
        out[plane] = @p@_saturated(out[plane] + @p@_rounded(share * (goal[plane] - out[plane]), 10));
}
