function mtf = mtf_of(edge, pitch_mm)
% ISETCam's ISO 12233 on a picture of the edge: curves of red, green, blue and luminance against cycles/mm, and MTF50 both on
% ISETCam's grid of 0.2 cycles/mm (`mtf50`) and interpolated linearly between the samples of a curve (`mtf50_exact`).
found = ISO12233(double(edge), pitch_mm, [], 'none');
mtf = struct('mtf50', found.mtf50, 'dx_mm', pitch_mm, 'nyquist', found.nyquistf, 'alias_pct', found.aliasingPercentage, ...
             'mtf50_exact', [], 'mtf50_rgb_exact', [], 'freq', found.freq, 'mtf', found.mtf);
each = arrayfun(@(c) half_of(found.freq, found.mtf(:, c)), 1:columns(found.mtf));
mtf.mtf50_exact = each(end);
mtf.mtf50_rgb_exact = each(1:end - 1);
end

function mtf50 = half_of(freq, curve)
k = find(curve < 0.5, 1);
mtf50 = interp1(curve(k - 1:k), freq(k - 1:k), 0.5);
end
