function s = nanstd(x)
% Standard deviation of each column without its NaN; Octave has no such function.
known = ~isnan(x);
residual = x - nanmean(x);
residual(~known) = 0;
s = sqrt(sum(residual .^ 2, 1) ./ (sum(known, 1) - 1));
end
